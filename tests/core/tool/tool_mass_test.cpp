// Compares a tool with mass with closed forms: free fall, springs, spinning tops, impacts,
// friction.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/tool_coupling/friction_solver.hpp"
#include "tests/core/massive_tool.hpp"

namespace feltwire::tool_mass_test {
namespace {

using test::box_inertia;
using test::kFace;
using test::kGravity;
using test::kStep;
using test::massive;
using test::Massive;
using test::object;

constexpr ToolIntegration kBoth[] = {ToolIntegration::implicit, ToolIntegration::midpoint};
constexpr double kLoose = 1e-9;  // [N/m], [N m/rad] stiffness of a negligible coupling
const Pose kOrigin{};

TEST(ToolMass, FallsAsTheIntegrationsSumsSay) {
  const Vec3 g(0.0, 0.0, -kGravity);
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(0.3, {.stiffness = kLoose, .rotational_stiffness = kLoose},
                         {.gravity = g, .integration = integration}));
    for (int n = 1; n <= 500; ++n) {
      tool.step(kOrigin);
      // Backward Euler: g h^2 n (n + 1) / 2. Midpoint: g t^2 / 2.
      const double steps = integration == ToolIntegration::implicit ? n * (n + 1.0) : n * n;
      ASSERT_NEAR(tool.memory.pose.position.z(), -0.5 * kGravity * kStep * kStep * steps, 1e-8);
      ASSERT_NEAR(tool.memory.velocity.linear.z(), -kGravity * kStep * n, 1e-7);
    }
  }
}

TEST(ToolMass, HangsBelowTheDeviceByItsWeight) {
  constexpr double kMass = 0.25, kSpring = 800.0;  // [kg], [N/m]
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(
        kMass, {.stiffness = kSpring},
        {.gravity = Vec3(0.0, 0.0, -kGravity), .damping = 10.0, .integration = integration}));
    Command felt;
    for (int n = 0; n < 3000; ++n) felt = tool.step(kOrigin).command;
    EXPECT_NEAR(tool.memory.pose.position.z(), -kMass * kGravity / kSpring, 1e-9);
    EXPECT_NEAR((felt.force() - Vec3(0.0, 0.0, -kMass * kGravity)).norm(), 0.0, 1e-6);
    EXPECT_EQ(felt.elastic, Vec3::Zero()) << "weight is of no surface";
    EXPECT_NEAR(felt.torque.norm(), 0.0, 1e-9);
  }
}

// With x' = x + h v' and v' = v - h w^2 x', each step multiplies the energy by 1 / (1 + (w h)^2)
// and advances the phase by atan(w h).
TEST(ToolMass, ImplicitDampsAnOscillationAsItsFormulaSays) {
  for (const double mass : {1e-3, 0.1, 10.0}) {
    const double spring = 1000.0, turn = std::sqrt(spring / mass) * kStep;
    Massive tool(massive(mass, {.stiffness = spring}, {}));
    tool.place({Vec3(0.005, 0.0, 0.0), Quaternion::Identity()});
    double before = 0.5 * spring * 0.005 * 0.005, phase = 0.0, scale = 0.005;
    for (int n = 0; n < 400; ++n) {
      const BodyStep now = tool.step(kOrigin);
      const double after = now.stored + now.kinetic;
      ASSERT_NEAR(after, before / (1.0 + turn * turn), 1e-9 * before + 1e-20) << mass << ' ' << n;
      before = after;
      phase += std::atan(turn);
      scale /= std::hypot(1.0, turn);
      ASSERT_NEAR(tool.memory.pose.position.x(), scale * std::cos(phase), 1e-8);
    }
  }
}

// The phase advances by 2 atan(w h / 2) per step. No energy is lost, even with varying steps.
TEST(ToolMass, MidpointKeepsTheEnergyOfASpring) {
  test::Random random(5);
  for (const double mass : {1e-3, 0.1, 10.0})
    for (const bool varied : {false, true}) {
      const double spring = 1000.0, rate = std::sqrt(spring / mass);
      Massive tool(
          massive(mass, {.stiffness = spring}, {.integration = ToolIntegration::midpoint}));
      tool.place({Vec3(0.005, 0.0, 0.0), Quaternion::Identity()});
      const double whole = 0.5 * spring * 0.005 * 0.005;
      double phase = 0.0;
      for (int n = 0; n < 5000; ++n) {
        const double h = varied ? random.uniform(0.2e-3, 5e-3) : kStep;
        const BodyStep now = tool.step(kOrigin, h);
        phase += 2.0 * std::atan(0.5 * rate * h);
        ASSERT_NEAR(now.stored + now.kinetic, whole, 1e-10 * whole) << mass << ' ' << n;
        ASSERT_NEAR(tool.memory.pose.position.x(), 0.005 * std::cos(phase), 1e-7);
      }
    }
}

TEST(ToolMass, OfARotationTheFormulasAreTheSame) {
  const double mass = 0.2, moment = box_inertia(mass)(2, 2), spring = 0.05;
  const double turn = std::sqrt(spring / moment) * kStep;
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(mass, {.stiffness = 1000.0, .rotational_stiffness = spring},
                         {.integration = integration}));
    tool.place({Vec3::Zero(), Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitZ()))});
    double before = 0.5 * spring * 0.3 * 0.3;
    for (int n = 0; n < 500; ++n) {
      const BodyStep now = tool.step(kOrigin);
      const double after = now.stored + now.kinetic;
      const double kept =
          integration == ToolIntegration::implicit ? 1.0 / (1.0 + turn * turn) : 1.0;
      ASSERT_NEAR(after, kept * before, 1e-9 * before) << n;
      before = after;
    }
  }
}

// Euler's equations without torque keep angular momentum and energy, to 1e-8 in 5 s. The tumbling
// must agree with steps ten times finer, up to a second-order error.
TEST(ToolMass, ATopKeepsMomentumAndEnergy) {
  const double mass = 0.2;
  const auto run = [&](ToolIntegration integration, double h) {
    Massive tool(massive(mass, {.stiffness = kLoose, .rotational_stiffness = 1e-18},
                         {.integration = integration}));
    tool.place(kOrigin);
    // The rotation about the middle axis is unstable.
    tool.memory.velocity.angular = Vec3(0.5, 10.0, 0.3);
    const Vec3 momentum = box_inertia(mass) * tool.memory.velocity.angular;
    const double energy = 0.5 * momentum.dot(tool.memory.velocity.angular);
    for (int n = 0; n < std::lround(5.0 / h); ++n) {
      const BodyStep now = tool.step(kOrigin, h);
      const Mat3 turn = tool.memory.pose.orientation.toRotationMatrix();
      const Vec3 has = turn * box_inertia(mass) * turn.transpose() * tool.memory.velocity.angular;
      EXPECT_LT((has - momentum).norm(), 1e-8 * momentum.norm()) << n;
      EXPECT_NEAR(now.kinetic, energy, 1e-8 * energy) << n;
    }
    return tool.memory.pose.orientation;
  };
  const Quaternion fine = run(ToolIntegration::implicit, 1e-4);
  for (const ToolIntegration integration : kBoth) {
    const double off = rotation_between(run(integration, 1e-3), fine).norm();
    EXPECT_LT(off, 0.05);
    EXPECT_GT(off, 1e-6) << "steps are felt";
    EXPECT_NEAR(rotation_between(run(integration, 2e-3), fine).norm() / off, 4.0, 0.8);
  }
}

// A hand that holds a rod off-centre gets the moment of its weight.
TEST(ToolMass, HeldBesideItsMiddleItTurnsTheHand) {
  constexpr double kMass = 0.15;
  const Vec3 center(0.02, 0.005, 0.0), weight(0.0, 0.0, -kMass * kGravity);
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(kMass, {.stiffness = 1000.0, .rotational_stiffness = 2.0},
                         {.center = center,
                          .gravity = weight / kMass,
                          .damping = 10.0,
                          .rotational_damping = 0.02,
                          .integration = integration}));
    Command felt;
    for (int n = 0; n < 5000; ++n) felt = tool.step(kOrigin).command;
    const Vec3 arm = tool.memory.pose.orientation * center;
    EXPECT_LT((felt.force() - weight).norm(), 1e-6);
    EXPECT_LT((felt.torque - arm.cross(weight)).norm(), 1e-8);
    EXPECT_GT(felt.torque.norm(), 0.02);
  }
}

TEST(ToolMass, AHandThatSpeedsUpFeelsMassTimesAcceleration) {
  constexpr double kMass = 0.4, kRate = 3.0;  // [kg], [m/s^2]
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(kMass, {}, {.damping = 40.0, .integration = integration}));
    Command felt;
    for (int n = 0; n < 1000; ++n) {
      const double t = n * kStep;
      felt = tool.step({Vec3(0.5 * kRate * t * t, 0.0, 0.0), Quaternion::Identity()}).command;
    }
    EXPECT_LT((felt.force() - Vec3(-kMass * kRate, 0.0, 0.0)).norm(), 1e-3 * kMass * kRate);
    // The tool must have the hand's acceleration.
    EXPECT_NEAR(tool.memory.velocity.linear.x(), kRate * 0.999, 0.02);
  }
}

// A tool that falls on a plane must rest where the plane carries its weight. The parts must report
// this force.
TEST(ToolMass, AfterAnImpactItRestsInThePlaneByItsWeight) {
  constexpr double kMass = 0.2;
  Object plane = object(Plane{});
  plane.material.damping = 5.0;
  Massive tool(massive(kMass, {.stiffness = kLoose}, {.gravity = Vec3(0, 0, -kGravity)}, 20000),
               {plane});
  tool.place({Vec3(0.0, 0.0, 0.03), Quaternion::Identity()});
  double fastest = 0.0, hardest = 0.0;
  BodyStep last;
  for (int n = 0; n < 3000; ++n) {
    last = tool.step(kOrigin);
    fastest = std::max(fastest, -tool.memory.velocity.linear.z());
    if (last.part_count > 0) hardest = std::max(hardest, last.parts[0].wrench.z());
  }
  EXPECT_NEAR(fastest, std::sqrt(2.0 * kGravity * 0.02), 0.1);
  EXPECT_GT(hardest, 3.0 * kMass * kGravity) << "an impact is felt by what is hit";
  const double sunk = 0.01 - tool.memory.pose.position.z();
  EXPECT_NEAR(test::flat_force(sunk, kFace), kMass * kGravity, 0.01 * kMass * kGravity);
  EXPECT_NEAR(sunk, kMass * kGravity / test::kStiffness, 0.1 * sunk);  // The sides carry a part.
  ASSERT_EQ(last.part_count, 1u);
  EXPECT_NEAR(last.parts[0].wrench.z(), kMass * kGravity, 1e-6);
  EXPECT_LT(last.command.force().norm(), 1e-6);
  EXPECT_LT(tool.memory.velocity.linear.norm(), 1e-6);
}

// A plane without friction or damping dissipates nothing. The midpoint rule must throw the tool
// back to its initial height, except for an energy error at the surface.
TEST(ToolMass, WithoutDampingTheMidpointRuleBouncesAndImplicitDoesNot) {
  const auto highest = [](ToolIntegration integration) {
    Massive tool(massive(0.2, {.stiffness = kLoose},
                         {.gravity = Vec3(0, 0, -kGravity), .integration = integration}, 20000),
                 {object(Plane{})});
    tool.place({Vec3(0.0, 0.0, 0.03), Quaternion::Identity()});
    double high = 0.0;
    bool met = false;
    for (int n = 0; n < 240; ++n) {
      met |= tool.step(kOrigin).touching > 0;
      if (met) high = std::max(high, tool.memory.pose.position.z());
    }
    return high - 0.01;
  };
  EXPECT_GT(highest(ToolIntegration::midpoint), 0.0185);
  EXPECT_LE(highest(ToolIntegration::midpoint), 0.02 + 1e-9);
  EXPECT_LT(highest(ToolIntegration::implicit), 0.017);
}

// The tool decelerates by mu g, stops, and stays. Friction creep is at most kHeld per step.
TEST(ToolMass, SlidesToAStopByFriction) {
  constexpr double kMass = 0.3, kSpeed = 0.4;  // [kg], [m/s]
  for (const ToolIntegration integration : kBoth) {
    Object plane = object(Plane{});
    plane.material.damping = 5.0;
    plane.material.static_friction = plane.material.dynamic_friction = 0.3;
    Massive tool(massive(kMass, {.stiffness = kLoose, .rotational_stiffness = kLoose},
                         {.gravity = Vec3(0, 0, -kGravity), .integration = integration}, 2000),
                 {plane});
    tool.place({Vec3(0.0, 0.0, 0.009), Quaternion::Identity()});
    for (int n = 0; n < 1000; ++n) tool.step(kOrigin);
    tool.memory.velocity.linear.x() = kSpeed;
    const double from = tool.memory.pose.position.x();
    for (int n = 0; n < 100; ++n) tool.step(kOrigin);
    EXPECT_NEAR(tool.memory.velocity.linear.x(), kSpeed - 0.3 * kGravity * 0.1, 0.01);
    for (int n = 0; n < 300; ++n) tool.step(kOrigin);
    const double way = kSpeed * kSpeed / (2.0 * 0.3 * kGravity);
    EXPECT_NEAR(tool.memory.pose.position.x() - from, way, 0.02 * way);
    for (int n = 0; n < 500; ++n) tool.step(kOrigin);  // The tool tilted during the slide.
    const double stopped = tool.memory.pose.position.x();
    for (int n = 0; n < 300; ++n) tool.step(kOrigin);
    EXPECT_NEAR(tool.memory.pose.position.x(), stopped, 300 * kHeld);
  }
}

// Friction alone, without a damper, must make a midpoint step implicit.
TEST(ToolMass, FrictionSlowsAMidpointToolToo) {
  Object plane = object(Plane{});
  plane.material.static_friction = plane.material.dynamic_friction = 0.3;
  Massive tool(
      massive(0.3, {.stiffness = kLoose, .rotational_stiffness = kLoose},
              {.gravity = Vec3(0, 0, -kGravity), .integration = ToolIntegration::midpoint}, 2000),
      {plane});
  tool.place({Vec3(0.0, 0.0, 0.009), Quaternion::Identity()});
  for (int n = 0; n < 1000; ++n) tool.step(kOrigin);
  tool.memory.velocity.linear.x() = 0.4;
  for (int n = 0; n < 100; ++n) tool.step(kOrigin);
  EXPECT_NEAR(tool.memory.velocity.linear.x(), 0.4 - 0.3 * kGravity * 0.1, 0.02);
}

}  // namespace
}  // namespace feltwire::tool_mass_test
