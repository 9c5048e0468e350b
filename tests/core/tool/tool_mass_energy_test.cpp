// Tests a tool with mass against malicious hands: energy, stability, limits.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/massive_tool.hpp"
#include "tests/support/same_twice.hpp"

namespace feltwire::tool_mass_energy_test {
namespace {

using test::grid_of;
using test::kGravity;
using test::kStep;
using test::massive;
using test::Massive;
using test::object;

constexpr ToolIntegration kBoth[] = {ToolIntegration::implicit, ToolIntegration::midpoint};
const Pose kOrigin{};

Object with(Object object, const Material& material) {
  object.material = material;
  return object;
}

std::vector<Object> corner(const Material& material) {
  return {with(object(grid_of(Sphere{0.03}, 1e-3)), material),
          with(object(Plane{}, Vec3(0, 0, -0.02)), material),
          with(object(Box{Vec3(0.02, 0.02, 0.02)}, Vec3(0.04, 0, 0)), material)};
}

// Tests the inequality of step_coupled_tool() in steps of any length. Stored and kinetic energy may
// grow by the hand's work against spring and damper at most. Spring and damper must not exceed
// their limits.
void energy_holds(const ToolIntegration integration, double mass, const Material& material,
                  double damping, std::uint64_t seed, double& touched) {
  const ToolCoupling coupling{.stiffness = 2000.0, .max_force = 15.0};
  Massive tool(massive(mass, coupling,
                       {.center = Vec3(0.004, -0.003, 0.002),
                        .gravity = Vec3(1.0, 0.0, -kGravity),
                        .damping = damping,
                        .rotational_damping = 1e-4 * damping,
                        .integration = integration},
                       300),
               corner(material));
  test::Random random(seed);
  Pose device{Vec3(0, 0, 0.04), Quaternion::Identity()};
  BodyStep last = tool.step(device);
  double moving = 0.0;
  int means = 0;
  for (int n = 0; n < 700; ++n) {
    const Pose before = device;
    const Vec3 turn = random.vector(-4.0, -1.0), by = random.vector(-6.0, -2.3);
    device = moved(device, by, turn);
    if (device.position.norm() > 0.08 || random.chance(0.2)) device = before;
    const double h = random.chance(0.1) ? random.uniform(0.0, 0.2) : random.uniform(2e-4, 4e-3);
    const double had = last.stored + last.kinetic + tool.weight();
    const Vec6 spring = tool.spring(before);
    const double lifted = tool.coupling_at(device) - tool.coupling_at(before);
    const BodyStep now = tool.step(device, h);
    Vec6 pulled, way;
    pulled << -now.command.force(), -now.command.torque;
    way << device.position - before.position,
        rotation_between(before.orientation, device.orientation);
    // The hand's work against the spring is either the change of the spring's energy or the mean
    // force times the movement.
    const double damper = (pulled - tool.spring(device)).dot(way);
    const double mean = 0.5 * (spring + tool.spring(device)).dot(way);
    const double rounding = 1e-12 * (1.0 + std::abs(had));
    ASSERT_LE(std::min(std::abs(now.work - damper - lifted), std::abs(now.work - damper - mean)),
              rounding);
    if (integration == ToolIntegration::implicit) {
      ASSERT_NEAR(now.work, damper + lifted, rounding);
    }
    means += std::abs(now.work - damper - mean) < rounding ? 1 : 0;
    const double has = now.stored + now.kinetic + tool.weight();
    ASSERT_LE(has, had + now.work + rounding) << n << ' ' << h;
    ASSERT_LE(now.command.force().norm(), coupling.max_force * (1.0 + 1e-9)) << n;
    ASSERT_LE(now.command.torque.norm(), tool.tool.coupling().max_torque * (1.0 + 1e-9)) << n;
    ASSERT_LE(now.command.elastic.norm(), now.command.force().norm() * (1.0 + 1e-9)) << n;
    const Vec3 contact = tool.memory.contact.wrench.head<3>();
    ASSERT_GE(now.command.elastic.dot(contact), 0.0) << n << ": no contact pulls";
    ASSERT_LE(now.command.elastic.norm(), contact.norm() * (1.0 + 1e-9)) << n;
    touched += static_cast<double>(now.touching);
    moving += now.kinetic;
    last = now;
  }
  EXPECT_GT(moving, 0.0);
  if (integration == ToolIntegration::midpoint) {
    EXPECT_GT(means, 100) << "it was not taken";
  }
}

TEST(ToolMassEnergy, AStepNeverAddsEnergy) {
  std::uint64_t seed = 1;
  double touched = 0.0;  // number of touching points over all steps
  for (const ToolIntegration integration : kBoth)
    for (const double mass : {1e-3, 0.1, 3.0})
      for (const Material& material : {Material{.stiffness = 1000.0}, Material{.stiffness = 1e6,
                                                                      .damping = 20.0,
                                                                      .static_friction = 0.6,
                                                                      .dynamic_friction = 0.4,
                                                                      .viscous_friction = 1.0}})
        for (const double damping : {0.0, 5.0, 500.0}) {
          SCOPED_TRACE(::testing::Message() << static_cast<int>(integration) << ' ' << mass << ' '
                                            << material.stiffness << ' ' << damping);
          energy_holds(integration, mass, material, damping, seed++, touched);
          if (HasFatalFailure()) return;
        }
  EXPECT_GT(touched, 1000.0);
}

// A tool hits a corner while the device rests. No energy may arise for any stiffness and mass, and
// the tool must come to rest.
TEST(ToolMassEnergy, AtEveryStiffnessAndMassItIsStable) {
  for (const ToolIntegration integration : kBoth)
    for (double stiffness = 1e2; stiffness < 2e7; stiffness *= 10.0)
      for (double mass = 1e-3; mass < 20.0; mass *= 10.0)
        for (const bool of_contact : {false, true}) {
          SCOPED_TRACE(::testing::Message() << static_cast<int>(integration) << ' ' << stiffness
                                            << ' ' << mass << ' ' << of_contact);
          const double spring = of_contact ? 1000.0 : stiffness;
          Material material{.stiffness = of_contact ? stiffness : 1000.0};
          material.damping = 2.0 * std::sqrt(material.stiffness * mass);
          const double damping = 2.0 * std::sqrt(spring * mass);
          Massive tool(massive(mass, {.stiffness = spring, .max_force = 200.0},
                               {.gravity = Vec3(0, 0, -kGravity),
                                .damping = damping,
                                .rotational_damping = 1e-3 * damping,
                                .integration = integration}),
                       {with(object(Plane{}), material)});
          tool.place({Vec3(0.0, 0.0, 0.015), Quaternion(Eigen::AngleAxisd(0.2, Vec3::UnitX()))});
          const Pose device{Vec3(0.0, 0.0, 0.008), Quaternion::Identity()};
          tool.memory.velocity.linear.z() = -0.5;
          double before = std::numeric_limits<double>::infinity();
          BodyStep now;
          for (int n = 0; n < 3000; ++n) {
            now = tool.step(device);
            const double after = now.stored + now.kinetic + tool.weight();
            ASSERT_TRUE(std::isfinite(after));
            ASSERT_LE(after, before + 1e-12 * (1.0 + std::abs(before))) << n;
            before = after;
          }
          EXPECT_LT(tool.memory.velocity.linear.norm(), 1e-3);
          EXPECT_LT(tool.memory.velocity.angular.norm(), 2e-2);
          // The forces must balance.
          double held = -now.command.force().z();
          for (const ObjectWrench& part : now.touched()) held += part.wrench.z();
          EXPECT_NEAR(held, mass * kGravity, 0.02 * mass * kGravity + 1e-3);
        }
}

// Without mass a tool must have the force of a tiny mass. The test uses backward Euler, because a
// light tool keeps oscillating under the midpoint rule.
TEST(ToolMassEnergy, ALittleMassIsNoMass) {
  const Material rough{.stiffness = 1000.0, .static_friction = 0.3, .dynamic_friction = 0.3};
  Massive light(massive(1e-9, {}, {.gravity = Vec3(0, 0, -kGravity)}, 500), corner(rough));
  Massive none(test::tool(500), corner(rough));
  test::Random random(4);
  Pose device{Vec3(0, 0, 0.045), Quaternion::Identity()};
  double felt = 0.0;
  for (int n = 0; n < 60; ++n) {
    device = moved(device, 2e-4 * random.direction() - Vec3(0, 0, 2e-4), 0.01 * random.direction());
    Command with, without;
    for (int k = 0; k < 10; ++k) {
      with = light.step(device).command;
      without = none.step(device).command;
    }
    EXPECT_LT((with.force() - without.force()).norm(), 0.01 + 0.01 * without.force().norm());
    EXPECT_LT((with.torque - without.torque).norm(), 1e-3);
    EXPECT_LT((with.elastic - without.elastic).norm(), 0.01 + 0.02 * without.force().norm());
    felt += without.force().norm();
  }
  EXPECT_GT(felt, 10.0);
}

// Without time nothing moves. An invalid time or pose must change nothing. A long pause must lead
// to equilibrium.
TEST(ToolMassEnergy, PausesAndNumbersThatAreNone) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const ToolIntegration integration : kBoth) {
    Massive tool(massive(0.2, {}, {.gravity = Vec3(0, 0, -kGravity), .integration = integration}));
    for (int n = 0; n < 20; ++n)
      tool.step({Vec3(1e-3 * n, 0.0, 0.0), Quaternion(Eigen::AngleAxisd(0.01 * n, Vec3::UnitX()))});
    const BodyMemory before = tool.memory;
    const auto unmoved = [&] {
      EXPECT_EQ(tool.memory.pose.position, before.pose.position);
      EXPECT_EQ(tool.memory.pose.orientation.coeffs(), before.pose.orientation.coeffs());
      EXPECT_EQ(tool.memory.velocity.linear, before.velocity.linear);
      EXPECT_EQ(tool.memory.velocity.angular, before.velocity.angular);
    };
    EXPECT_GT(before.velocity.linear.norm(), 0.1);
    for (const double h : {0.0, -1.0, nan, infinity, -infinity}) {
      const Pose device{Vec3(0.02, 0.0, 0.0), Quaternion::Identity()};
      const Command felt = tool.step(device, h).command;
      unmoved();
      EXPECT_LT((felt.force() - 1000.0 * (before.pose.position - device.position)).norm(), 1e-9);
    }
    EXPECT_EQ(tool.step({Vec3(nan, 0, 0), Quaternion::Identity()}).command, Command{});
    EXPECT_EQ(tool.step({Vec3::Zero(), Quaternion(0, 0, 0, 0)}).command, Command{});
    unmoved();
    EXPECT_TRUE(tool.step({Vec3::Constant(1e300), Quaternion::Identity()}).command.finite());
    tool.memory = before;
    tool.step(kOrigin, 100.0);
    EXPECT_LT(tool.memory.velocity.linear.norm(), 1e-3);
    EXPECT_LT((tool.memory.pose.position - Vec3(0, 0, -0.2 * kGravity / 1000.0)).norm(), 1e-5);
  }
}

// The tool moves 24 mm per step when it hits a sampled wall of 20 mm. The wall must stop it.
TEST(ToolMassEnergy, AFastToolDoesNotPassAWall) {
  for (const ToolIntegration integration : kBoth) {
    Massive tool(
        massive(0.005, {.stiffness = 1000.0, .max_force = 5.0}, {.integration = integration}, 2000),
        {with(object(grid_of(Box{Vec3(0.2, 0.2, 0.01)}, 1e-3)), {.stiffness = 1e5})});
    tool.place({Vec3(0, 0, 0.3), Quaternion::Identity()});
    double fastest = 0.0, lowest = 1.0;
    for (int n = 0; n < 2000; ++n) {
      tool.step({Vec3(0, 0, -0.3), Quaternion::Identity()});
      fastest = std::max(fastest, -tool.memory.velocity.linear.z());
      lowest = std::min(lowest, tool.memory.pose.position.z());
    }
    EXPECT_GT(fastest, 20.0);
    EXPECT_GT(lowest, 0.0);
  }
}

TEST(ToolMassEnergy, BeginsAtRestAtTheDevice) {
  Massive tool(massive(1.0, {}, {}));
  const Pose device{Vec3(0.3, 0.2, 0.1), Quaternion(Eigen::AngleAxisd(1.0, Vec3::UnitZ()))};
  const BodyStep first = tool.step(device);
  EXPECT_LT(first.command.force().norm() + first.command.torque.norm(), 1e-9);
  EXPECT_LT(first.kinetic, 1e-15);
  EXPECT_LT((tool.memory.pose.position - device.position).norm(), 1e-12);
}

TEST(ToolMassEnergy, RefusesWhatIsNoBody) {
  const auto make = [](ToolInertia inertia) {
    if (inertia.inertia.isZero()) inertia.inertia = test::box_inertia(1.0);
    return BodyTool(test::box_shell(10), {}, 0.0, inertia);
  };
  const double nan = std::nan("");
  EXPECT_NO_THROW(make({.mass = 1.0}));
  EXPECT_NO_THROW(BodyTool(test::box_shell(10), {}, 0.0, ToolInertia{}));
  EXPECT_THROW(make({.mass = -1.0}), std::invalid_argument);
  EXPECT_THROW(make({.mass = nan}), std::invalid_argument);
  EXPECT_THROW(make({.mass = 1.0, .center = Vec3(nan, 0, 0)}), std::invalid_argument);
  EXPECT_THROW(make({.mass = 1.0, .gravity = Vec3(0, nan, 0)}), std::invalid_argument);
  EXPECT_THROW(make({.mass = 1.0, .damping = -1.0}), std::invalid_argument);
  EXPECT_THROW(make({.mass = 1.0, .rotational_damping = nan}), std::invalid_argument);
  EXPECT_THROW(make({.mass = 1.0, .inertia = Vec3(1, 1, -1).asDiagonal().toDenseMatrix()}),
               std::invalid_argument);
}

TEST(ToolMassEnergy, TheSameBitsEveryTimeAndNoAllocation) {
  for (const ToolIntegration integration : kBoth) {
    const BodyTool body =
        massive(0.1, {}, {.gravity = Vec3(0, 0, -kGravity), .integration = integration}, 1000);
    const std::vector<Object> objects = corner({.stiffness = 1000.0});
    const auto run = [&] {
      BodyMemory memory;
      Command sum;
      for (int i = 0; i < 500; ++i) {
        const double t = 0.01 * i;
        const Pose device = moved(
            {Vec3(0.01 * std::sin(t), 0.0, 0.04 - 0.01 * std::sin(3 * t)), Quaternion::Identity()},
            Vec3::Zero(), Vec3(0.1 * std::sin(2 * t), 0.2 * t, 0.0));
        const Command c = step_body(body, objects, device, kStep, memory).command;
        sum.elastic += c.elastic;
        sum.torque += c.torque;
      }
      return sum;
    };
    EXPECT_GT(test::same_twice_without_allocation(run).elastic.norm(), 1.0);
  }
}

}  // namespace
}  // namespace feltwire::tool_mass_energy_test
