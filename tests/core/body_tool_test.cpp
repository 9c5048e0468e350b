// A body in the hand: shell, contact and coupling against closed forms, and against hands that mean
// harm.

#include "core/tool/body_tool.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/bounding/bounding.hpp"
#include "core/geometry/signed_distance.hpp"
#include "core/geometry/tessellation.hpp"
#include "core/port_energy.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::body_tool_test {
namespace {

const Vec3 kHalf(0.03, 0.02, 0.01);  // [m] of the body that most tests hold
constexpr double kStiffness = 1000.0;

PointShell box_shell(std::size_t count) { return point_shell(tessellate(Box{kHalf}, 3), count); }

Object object(const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = "o";
  o.shape = shape;
  o.pose.position = position;
  o.material.stiffness = kStiffness;
  return o;
}

Grid grid_of(const Shape& shape, double resolution) {
  return {std::make_shared<DistanceGrid<float>>(solid_of(shape),
                                                GridOptions{.resolution = resolution})};
}

ShellContact contact(const PointShell& shell, const Pose& pose, const Object& o, double area) {
  ShellContact sum;
  add_contact(shell, pose, o, area, sum);
  return sum;
}

TEST(PointShell, IsEvenOverTheSurface) {
  const std::size_t count = 6000;
  const PointShell shell = box_shell(count);
  ASSERT_EQ(shell.points.size(), count);
  EXPECT_NEAR(shell.area, 8.0 * (0.03 * 0.02 + 0.02 * 0.01 + 0.03 * 0.01), 1e-12);
  Vec3 middle = Vec3::Zero();
  std::array<int, 3> on{};  // faces across x, y, z
  for (const Vec3& p : shell.points) {
    middle += p / static_cast<double>(count);
    const Vec3 beyond = p.cwiseAbs() - kHalf;
    EXPECT_NEAR(beyond.maxCoeff(), 0.0, 1e-15);
    for (int axis = 0; axis < 3; ++axis)
      on[static_cast<std::size_t>(axis)] += beyond[axis] > -1e-12 ? 1 : 0;
  }
  EXPECT_LT(middle.norm(), 1e-4);
  EXPECT_NEAR(on[0], count * 2 / 11, 2);  // 2 of 11 parts of the area
  EXPECT_NEAR(on[1], count * 3 / 11, 2);
  EXPECT_NEAR(on[2], count * 6 / 11, 2);
  // No hole: a point within three mean distances of everywhere on the large face.
  const double near = 3.0 * std::sqrt(shell.area / static_cast<double>(count));
  for (double x = -0.03; x <= 0.03; x += 0.003)
    for (double y = -0.02; y <= 0.02; y += 0.004) {
      double nearest = 1.0;
      for (const Vec3& p : shell.points) nearest = std::min(nearest, (p - Vec3(x, y, 0.01)).norm());
      EXPECT_LT(nearest, near);
    }
}

TEST(PointShell, ItsTreeHoldsEveryPointOnce) {
  const PointShell shell = box_shell(1000);
  std::vector<int> seen(1000, 0);
  for (std::size_t n = 0; n < shell.nodes.size(); ++n) {
    const ShellNode& node = shell.nodes[n];
    ASSERT_GT(node.next, n);
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      EXPECT_LE((shell.points[i] - node.center).norm(), node.radius * (1.0 + 1e-12));
    if (node.next != n + 1) continue;
    for (std::uint32_t i = node.begin; i < node.end; ++i) ++seen[i];
  }
  EXPECT_EQ(shell.nodes[0].next, shell.nodes.size());
  for (const int times : seen) EXPECT_EQ(times, 1);
}

TEST(PointShell, RefusesNothingAndTooMuch) {
  const TriangleSoup box = tessellate(Box{kHalf}, 3);
  EXPECT_THROW(point_shell(box, 0), std::invalid_argument);
  EXPECT_THROW(point_shell(box, kMaxShellPoints + 1), std::invalid_argument);
  TriangleSoup flat = box;
  for (Vec3& v : flat.vertices) v.setZero();
  EXPECT_THROW(point_shell(flat, 10), std::invalid_argument);
  EXPECT_EQ(point_shell(box, 1).points.size(), 1u);
}

constexpr double kFace = 4.0 * 0.03 * 0.02;     // [m^2] that it stands on
constexpr double kRound = 4.0 * (0.03 + 0.02);  // [m] the way round it

/// [N] The face and the sides below the plane, pressed in by d: k / A_c (A d + P d^2 / 2).
double flat_force(double d, double area) {
  return kStiffness / area * (kFace * d + 0.5 * kRound * d * d);
}

TEST(ShellContact, ABoxFlatOnAPlane) {
  constexpr double kDepth = 2e-3;
  const Object plane = object(Plane{});
  const double force = flat_force(kDepth, kFace);
  for (const std::size_t count : {100u, 1000u, 10000u}) {
    const PointShell shell = box_shell(count);
    const ShellContact c =
        contact(shell, {Vec3(0.1, 0.2, 0.01 - kDepth), Quaternion::Identity()}, plane, kFace);
    const double share = 1.0 / std::sqrt(static_cast<double>(count));  // of the way to a neighbour
    EXPECT_NEAR(c.wrench[2], force, 0.5 * share * force) << count;
    EXPECT_EQ(c.wrench.head<2>(), Eigen::Vector2d::Zero());
    EXPECT_NEAR(c.wrench[3], 0.0, 0.02 * share * force) << count;
    EXPECT_NEAR(c.wrench[4], 0.0, 0.03 * share * force) << count;
    const double energy =
        kStiffness / kFace * (kFace * kDepth * kDepth / 2.0 + kRound * std::pow(kDepth, 3) / 6.0);
    EXPECT_NEAR(c.energy, energy, 0.5 * share * energy) << count;
  }
}

// Turned by a small angle about y: depth d + x sin a; torque k Iy sin a / A_c, Iy the face's second
// moment of area.
TEST(ShellContact, ABoxTurnedOnAPlane) {
  constexpr double a = 0.03, angle = 1e-3, d = 2e-4;
  const PointShell shell = box_shell(40000);
  const ShellContact c =
      contact(shell, {Vec3(0, 0, 0.01 - d), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()))},
              object(Plane{}), kFace);
  // To first order in the angle, the sides included.
  const double second =
      0.04 * std::pow(2.0 * a, 3) / 12.0 + d * (0.08 * a * a + 4.0 / 3.0 * a * a * a);
  const double torque = kStiffness / kFace * second * angle;
  EXPECT_NEAR(c.wrench[4], -torque, 0.01 * torque);
  EXPECT_NEAR(c.wrench[2], flat_force(d, kFace), 0.01 * flat_force(d, kFace));
}

// Pushed down off its centre the plane's answer is a torque: the contact's centre is off.
TEST(ShellContact, TheForceActsWhereThePointsAre) {
  const double area = kFace;
  const PointShell shell = box_shell(20000);
  // Only x > 0 of the bottom stands on the step.
  const Object step = object(Box{Vec3(0.05, 0.05, 0.05)}, Vec3(0.05, 0, -0.05));
  const ShellContact c =
      contact(shell, {Vec3(0, 0, 0.01 - 1e-4), Quaternion::Identity()}, step, area);
  EXPECT_NEAR(c.wrench[2], 0.5 * kStiffness * 1e-4, 0.03 * kStiffness * 1e-4);
  EXPECT_NEAR(c.wrench[4], -0.015 * c.wrench[2], 0.02 * 0.015 * c.wrench[2]);
}

TEST(ShellContact, TheWrenchIsTheEnergysGradientAndTheStiffnessItsSecond) {
  const PointShell shell = box_shell(500);
  const double area = shell.area;
  const Object ball = object(grid_of(Sphere{0.03}, 1e-3), Vec3(0.1, -0.2, 0.3));
  const Pose pose = moved({ball.pose.position + Vec3(0.005, -0.01, 0.036), Quaternion::Identity()},
                          Vec3::Zero(), Vec3(0.3, -0.2, 0.5));
  const ShellContact c = contact(shell, pose, ball, area);
  ASSERT_GT(c.touching, 5u);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    Vec6 by = Vec6::Zero();
    by[i] = kStep;
    const ShellContact up = contact(shell, moved(pose, by.head<3>(), by.tail<3>()), ball, area);
    const ShellContact down = contact(shell, moved(pose, -by.head<3>(), -by.tail<3>()), ball, area);
    const double scale = i < 3 ? 1.0 : 0.03;
    EXPECT_NEAR(c.wrench[i], -(up.energy - down.energy) / (2.0 * kStep),
                3e-4 * c.wrench.head<3>().norm() * scale);
    // The Gauss-Newton part leaves out what the field's own curvature does, depth over radius.
    EXPECT_NEAR(c.stiffness(i, i), -(up.wrench[i] - down.wrench[i]) / (2.0 * kStep),
                0.25 * c.stiffness.diagonal().head<3>().sum() * scale * scale);
  }
  EXPECT_LT((c.stiffness - c.stiffness.transpose()).norm(), 1e-9 * c.stiffness.norm());
}

TEST(ShellContact, FarPointsCostNothing) {
  const PointShell shell = box_shell(10000);
  for (const Shape& shape : {Shape(Plane{}), Shape(grid_of(Box{Vec3(0.1, 0.1, 0.02)}, 1e-3))}) {
    const Object o = object(shape);
    const double top = std::holds_alternative<Plane>(shape) ? 0.0 : 0.02;
    const auto looked = [&](double gap) {
      return contact(shell, {Vec3(0, 0, top + 0.01 + gap), Quaternion::Identity()}, o, 1e-3)
          .looked_at;
    };
    EXPECT_EQ(looked(0.1), 1u);
    EXPECT_LE(looked(0.05), 1u);
    EXPECT_LT(looked(0.005), 500u);
    const ShellContact touching =
        contact(shell, {Vec3(0, 0, top + 0.01 - 1e-4), Quaternion::Identity()}, o, 1e-3);
    EXPECT_GT(touching.touching, 2500u);   // the whole face
    EXPECT_LT(touching.looked_at, 6000u);  // and little more than it
  }
}

TEST(ShellContact, TheClearanceIsNoLie) {
  const PointShell shell = box_shell(1000);
  const Object ball = object(grid_of(Sphere{0.03}, 1e-3));
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Pose pose{random.uniform(0.04, 0.2) * random.direction(),
                    Quaternion(Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()))};
    double nearest = 1.0;
    for (const Vec3& p : shell.points) {
      const double d = (pose.position + pose.orientation * p).norm() - 0.03;
      if (d > 0.0) nearest = std::min(nearest, d);
    }
    EXPECT_LE(contact(shell, pose, ball, 1e-3).clearance, nearest + 1e-6);
  }
}

BodyTool tool(std::size_t points = 2000, const ToolCoupling& coupling = {}) {
  return {box_shell(points), coupling, kFace};
}

TEST(BodyTool, RefusesWhatIsNoCoupling) {
  const auto make = [](ToolCoupling c, double area) { return BodyTool(box_shell(10), c, area); };
  EXPECT_NO_THROW(make({}, 0.0));
  EXPECT_THROW(make({.stiffness = 0.0}, 0.0), std::invalid_argument);
  EXPECT_THROW(make({.stiffness = std::nan("")}, 0.0), std::invalid_argument);
  EXPECT_THROW(make({.max_force = -1.0}, 0.0), std::invalid_argument);
  EXPECT_THROW(make({.rotational_stiffness = -1.0}, 0.0), std::invalid_argument);
  EXPECT_THROW(make({.max_torque = -1.0}, 0.0), std::invalid_argument);
  EXPECT_THROW(make({}, -1.0), std::invalid_argument);
  EXPECT_THROW(BodyTool(PointShell{}, {}, 1.0), std::invalid_argument);
}

TEST(BodyTool, InFreeSpaceGivesNothing) {
  const BodyTool body = tool();
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  test::Random random(2);
  Pose device{Vec3(0, 0, 1), Quaternion::Identity()};
  for (int i = 0; i < 1000; ++i) {
    device = moved(device, random.uniform(0, 0.01) * random.direction(),
                   random.uniform(0, 0.3) * random.direction());
    device.position.z() = std::max(device.position.z(), 0.2);
    const BodyStep step = step_body(body, objects, device, memory);
    EXPECT_LT(step.command.force().norm(), 1e-5);
    EXPECT_LT(step.command.torque.norm(), 1e-6);
    EXPECT_LE(step.evaluations, 3u);
  }
}

// Two springs in a row: coupling and contact have the same force, up to the coupling's most.
TEST(BodyTool, OnAPlaneIsTwoSpringsInARow) {
  const BodyTool body = tool(20000, {.stiffness = 500.0, .max_force = 3.0});
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  step_body(body, objects, {Vec3(0, 0, 0.011), Quaternion::Identity()}, memory);
  for (double d = 0.0; d < 0.02; d += 1e-4) {
    const Command c =
        step_body(body, objects, {Vec3(0, 0, 0.01 - d), Quaternion::Identity()}, memory).command;
    const double sunk = 0.01 - memory.pose.position.z();
    EXPECT_NEAR(c.elastic.z(), flat_force(sunk, kFace), 0.02) << d;
    EXPECT_NEAR(c.elastic.z(), std::min(3.0, 500.0 * (d - sunk)), 1e-9) << d;
    EXPECT_LT(c.torque.norm(), 2e-4);
    EXPECT_LE(c.elastic.norm(), 3.0 * (1.0 + 1e-12));
  }
}

// A hand that turns the box on the plane feels the moment of the face it stands on, two springs in
// a row again.
TEST(BodyTool, TurnedOnAPlaneGivesTorque) {
  const BodyTool body =
      tool(40000, {.stiffness = 1e6, .rotational_stiffness = 0.3, .max_force = 100});
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  step_body(body, objects, {Vec3(0, 0, 0.0101), Quaternion::Identity()}, memory);
  const double contact = kStiffness * 0.06 * 0.06 / 12.0;  // [N m/rad] of the face
  const double angle = 1e-3, expected = angle * 0.3 * contact / (0.3 + contact);
  Command c;
  for (int i = 0; i < 20; ++i)
    c = step_body(body, objects,
                  {Vec3(0, 0, 0.01 - 2e-4), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()))},
                  memory)
            .command;
  EXPECT_NEAR(c.torque.y(), -expected, 0.03 * expected);
  EXPECT_NEAR(c.elastic.z(), kStiffness * 2e-4, 0.02 * kStiffness * 2e-4);
}

TEST(BodyTool, AFastHandDoesNotTakeTheToolThroughAWall) {
  const BodyTool body = tool(2000, {.max_force = 5.0});  // sinks in by 5 mm
  // 20 mm of wall, sampled; the hand comes at 10 m/s and stops 0.3 m behind it.
  const std::vector<Object> objects = {object(grid_of(Box{Vec3(0.2, 0.2, 0.01)}, 1e-3))};
  for (const double stride : {0.01, 0.6}) {  // 10 m/s, and a hand that is there at once
    BodyMemory memory;
    for (double z = 0.3; z > -0.3; z -= stride)
      step_body(body, objects, {Vec3(0, 0, z), Quaternion::Identity()}, memory);
    Command c;
    for (int i = 0; i < 100; ++i)
      c = step_body(body, objects, {Vec3(0, 0, -0.3), Quaternion::Identity()}, memory).command;
    EXPECT_GT(memory.pose.position.z(), 0.0) << stride;
    EXPECT_NEAR(c.elastic.z(), 5.0, 1e-9) << stride;  // all that the coupling gives
  }
}

// The energy stored can only come from the hand: whatever it does, however it turns, what the steps
// add beyond the work against the coupling's force is nothing. And the parts that the hand moves
// against in one go are bounded by the held force's own work.
TEST(BodyTool, AStepNeverAddsEnergy) {
  const BodyTool body = tool(500, {.stiffness = 2000.0});
  const std::vector<Object> objects = {object(grid_of(Sphere{0.03}, 1e-3)),
                                       object(Plane{}, Vec3(0, 0, -0.02)),
                                       object(Box{Vec3(0.02, 0.02, 0.02)}, Vec3(0.04, 0, 0))};
  BodyMemory memory;
  test::Random random(3);
  Pose device{Vec3(0, 0, 0.04), Quaternion::Identity()};
  BodyStep last = step_body(body, objects, device, memory);
  const ToolCoupling& k = body.coupling();
  const auto coupling_energy = [&](const Pose& at) {
    const auto huber = [](double x, double stiffness, double most) {
      return x < most / stiffness ? 0.5 * stiffness * x * x : most * (x - 0.5 * most / stiffness);
    };
    return huber((at.position - memory.pose.position).norm(), k.stiffness, k.max_force) +
           huber(rotation_between(memory.pose.orientation, at.orientation).norm(),
                 k.rotational_stiffness, k.max_torque);
  };
  double touched = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const Pose before = device;
    device = moved(device, random.vector(-6.0, -2.3), random.vector(-4.0, -1.0));
    if (device.position.norm() > 0.08) device = before;
    const double worked = coupling_energy(device) - coupling_energy(before);
    const BodyStep step = step_body(body, objects, device, memory);
    EXPECT_LE(step.stored, last.stored + worked + 1e-12);
    touched += static_cast<double>(step.touching);
    last = step;
  }
  EXPECT_GT(touched, 1e4);
}

// The greediest hand against the whole chain: body, then the bound, rotation and torque included.
TEST(BodyTool, BehindTheBoundNoHandGainsEnergy) {
  const BodyTool body = tool(300, {.stiffness = 5000.0});
  const std::vector<Object> objects = {object(grid_of(Sphere{0.03}, 1e-3)),
                                       object(Plane{}, Vec3(0, 0, -0.02))};
  BoundingConfig config = test::config(BoundingMode::contact_frame);
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Bounding bounding(config);
    PortEnergy port(config.damping, config.rotational_damping, config.period, 1e-12);
    BodyMemory memory;
    test::Random random(seed);
    Pose device{Vec3(0, 0, 0.042), Quaternion::Identity()};
    Command held;
    double largest = 0.0;
    for (int i = 0; i < 1500; ++i) {
      // Now with the force, as it takes most out of the port, now back in.
      Vec3 by = test::greediest(held.force(), config.period, 0.5);
      Vec3 turn = test::greediest(held.torque, config.period, 1e-3);
      if (random.chance(0.5)) by = -random.uniform(0.0, 1e-3) * device.position.normalized();
      if (random.chance(0.3)) turn = random.uniform(0.0, 0.05) * random.direction();
      device = moved(device, by, turn);
      port.step(held, by, turn, config.period);
      const Command wanted = step_body(body, objects, device, memory).command;
      held = bounding.step({by, turn, config.period, wanted}).rendered;
      largest = std::max(largest, held.torque.norm());
    }
    EXPECT_EQ(port.violations(), 0u) << seed;
    EXPECT_GT(largest, 1e-4);  // there was torque to gain from
  }
}

TEST(BodyTool, APoseThatIsNoneGivesZeroAndIsForgotten) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const BodyTool body = tool(200);
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  const Pose in{Vec3(0, 0, 0.009), Quaternion::Identity()};
  step_body(body, objects, {Vec3(0, 0, 0.02), Quaternion::Identity()}, memory);
  const Command before = step_body(body, objects, in, memory).command;
  EXPECT_GT(before.elastic.z(), 0.0);
  const Pose held = memory.pose;
  for (const Pose& bad :
       {Pose{Vec3(nan, 0, 0), Quaternion::Identity()},
        Pose{Vec3(0, 0, infinity), Quaternion::Identity()},
        Pose{Vec3::Zero(), Quaternion(0, 0, 0, 0)}, Pose{Vec3::Zero(), Quaternion(nan, 0, 0, 1)},
        Pose{Vec3::Constant(1e300), Quaternion(1e200, 0, 0, 1e200)}}) {
    const Command c = step_body(body, objects, bad, memory).command;
    EXPECT_TRUE(c.finite());
    if (!bad.position.allFinite() || !std::isfinite(bad.orientation.squaredNorm()) ||
        bad.orientation.squaredNorm() == 0.0) {
      EXPECT_EQ(c, Command{});
      EXPECT_EQ(memory.pose.position, held.position);
    }
  }
  const Command after = step_body(body, objects, in, memory).command;
  EXPECT_NEAR(after.elastic.z(), before.elastic.z(), 1e-3);
}

TEST(BodyTool, TheSameBitsEveryTimeAndNoAllocation) {
  const BodyTool body = tool(1000);
  const std::vector<Object> objects = {object(grid_of(Sphere{0.03}, 1e-3)), object(Plane{})};
  const auto run = [&] {
    BodyMemory memory;
    Command sum;
    for (int i = 0; i < 500; ++i) {
      const double t = 0.01 * i;
      const Pose device = moved(
          {Vec3(0.01 * std::sin(t), 0.0, 0.04 - 0.01 * std::sin(3 * t)), Quaternion::Identity()},
          Vec3::Zero(), Vec3(0.1 * std::sin(2 * t), 0.2 * t, 0.0));
      const Command c = step_body(body, objects, device, memory).command;
      sum.elastic += c.elastic;
      sum.torque += c.torque;
    }
    return sum;
  };
  const std::size_t before = test::allocations();
  const Command first = run();
#ifndef FELTWIRE_SANITIZED
  EXPECT_EQ(test::allocations(), before);
#else
  static_cast<void>(before);
#endif
  EXPECT_EQ(first, run());
  EXPECT_GT(first.elastic.norm(), 1.0);
}

}  // namespace
}  // namespace feltwire::body_tool_test
