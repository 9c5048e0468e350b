// Tests the resistance to a tool with a body: friction, contact damping, viscosity.

#include <gtest/gtest.h>

#include <cmath>

#include "core/tool_coupling/friction_solver.hpp"
#include "tests/core/bodies.hpp"
#include "tests/core/support.hpp"
#include "tests/support/same_twice.hpp"

namespace feltwire::body_friction_test {
namespace {

using test::box_shell;
using test::grid_of;
using test::kFace;
using test::kStiffness;
using test::object;
using test::step;
using test::tool;

constexpr double kStatic = 0.5, kDynamic = 0.3;

Object rough(const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object o = object(shape, position);
  o.material.static_friction = kStatic;
  o.material.dynamic_friction = kDynamic;
  return o;
}

const Quaternion kUpright = Quaternion::Identity();

/// Lowers the box onto a floor at z = 0, until the device is deeper by `pressed` [m].
BodyStep lowered(const BodyTool& body, const std::vector<Object>& objects, double pressed,
                 BodyMemory& memory) {
  BodyStep last;
  for (int i = 0; i <= 20; ++i)
    last = step(body, objects, {Vec3(0, 0, 0.0101 - pressed * i / 20.0), kUpright}, memory);
  return last;
}

TEST(Sliding, MakesLeastOfWhatTheMotionCosts) {
  test::Random random(1);
  const PointShell shell = box_shell(300);
  int held = 0, slipped = 0;
  for (int n = 0; n < 300; ++n) {
    ShellContact sum;
    const Pose pose{Vec3(0.0, 0.0, random.uniform(0.005, 0.012)),
                    Quaternion(Eigen::AngleAxisd(random.uniform(0.0, 0.1), random.direction()))};
    add_contact(shell, pose, rough(Plane{}), kFace, sum);
    if (n % 2 == 0)
      add_contact(shell, pose, rough(Box{Vec3(0.01, 0.1, 0.1)}, Vec3(0.039, 0, 0)), kFace, sum);
    if (sum.grip_count == 0) continue;
    Mat6 stiffness = sum.stiffness;
    stiffness.diagonal().head<3>().array() += 1000.0;
    stiffness.diagonal().tail<3>().array() += 1.0;
    Vec6 wrench;
    wrench << random.vector(-2.0, 1.0), random.vector(-4.0, -1.0);
    const FrictionSolution found = solve_friction(stiffness, wrench, sum.gripping(), true);
    const auto cost = [&](const Vec6& m) {
      return 0.5 * m.dot(stiffness * m) - wrench.dot(m) + friction_work(sum.gripping(), true, m);
    };
    const double least = cost(found.motion), scale = std::abs(least) + 1e-12;
    for (int k = 0; k < 60; ++k) {
      Vec6 by;
      by << random.vector(-9.0, -3.0), random.vector(-8.0, -2.0);
      EXPECT_GE(cost(found.motion + by), least - 1e-4 * scale) << n;
    }
    // The friction does no work at rest, except for the compliance of a sticking patch.
    EXPECT_LE(least, 1e-8) << n;
    ++(found.slips ? slipped : held);
    // At the end of the motion the forces must balance.
    Vec6 rest = wrench - stiffness * found.motion;
    for (std::size_t i = 0; i < sum.grip_count; ++i) rest += found.friction[i];
    EXPECT_LE(rest.norm(), 1e-6 * wrench.norm()) << n;
  }
  EXPECT_GT(held, 10);
  EXPECT_GT(slipped, 100);
}

// On a flat floor, friction mu N acts at the face. This force gives the torque r x F about the
// tool's origin.
TEST(Sliding, AFaceIsHeldAtTheFloor) {
  constexpr double kDepth = 5e-4;
  ShellContact sum;
  add_contact(box_shell(20000), {Vec3(0, 0, 0.01 - kDepth), kUpright}, rough(Plane{}), kFace, sum);
  ASSERT_EQ(sum.grip_count, 1u);
  const double load = sum.wrench[2];
  EXPECT_NEAR(sum.patches[0].load, load, 1e-12 * load);
  const Mat6 stiffness = 1000.0 * Mat6::Identity();
  Vec6 wrench = Vec6::Zero();
  wrench[0] = 2.0 * load;
  const FrictionSolution s = solve_friction(stiffness, wrench, sum.gripping(), true);
  EXPECT_TRUE(s.slips);
  EXPECT_NEAR(s.friction[0][0], -kDynamic * load, 2e-3 * load);
  EXPECT_NEAR(s.friction[0][1], 0.0, 2e-3 * load);
  EXPECT_NEAR(s.friction[0][2], 0.0, 1e-6 * load);
  EXPECT_NEAR(s.friction[0][4], 0.01 * kDynamic * load, 0.05 * 0.01 * kDynamic * load);
  EXPECT_NEAR(s.friction[0][5], 0.0, 1e-4 * load);
  // A rotation in place gives mu N times the root mean square arm of the face.
  wrench.setZero();
  wrench[5] = load;
  const double arm = std::sqrt((0.06 * 0.06 + 0.04 * 0.04) / 12.0);
  const FrictionSolution spun = solve_friction(stiffness, wrench, sum.gripping(), true);
  EXPECT_NEAR(spun.friction[0][5], -kDynamic * load * arm, 0.02 * kDynamic * load * arm);
  EXPECT_LE(std::abs(spun.friction[0][0]) + std::abs(spun.friction[0][1]), 5e-3 * load);
}

TEST(BodyFriction, DraggedAlongAFloorItIsHeldBackByMuN) {
  const std::vector<Shape> floors = {Plane{}, grid_of(Box{Vec3(0.3, 0.3, 0.02)}, 2e-3)};
  const BodyTool body = tool(1000);
  for (const Shape& floor : floors) {
    const double below = std::holds_alternative<Plane>(floor) ? 0.0 : -0.02;
    const std::vector<Object> objects = {rough(floor, Vec3(0, 0, below))};
    BodyMemory memory;
    lowered(body, objects, 3e-3, memory);
    const Vec3 way = Vec3(0.8, -0.6, 0.0);
    double most = 0.0;
    for (int i = 1; i <= 1000; ++i) {
      const Command c =
          step(body, objects, {Vec3(5e-5 * i * way) + Vec3(0, 0, 0.0071), kUpright}, memory)
              .command;
      const double load = c.elastic.z(), held = -c.force().dot(way);
      ASSERT_GT(load, 0.5);
      EXPECT_LE(held, kStatic * load * 1.02) << i;
      most = std::max(most, held / load);
      if (i < 500) continue;
      EXPECT_NEAR(held, kDynamic * load, 0.02 * load) << i;
      EXPECT_NEAR(c.force().dot(Vec3(0.6, 0.8, 0.0)), 0.0, 0.01 * load) << i;
      EXPECT_NEAR(c.frictional.dot(way), -held, 0.01 * load) << i;
    }
    EXPECT_GT(most, 0.9 * kStatic);  // The tool had to break loose.
  }
}

TEST(BodyFriction, WhatIsHeldDoesNotCreep) {
  const BodyTool body = tool(1000);
  const std::vector<Object> objects = {rough(Plane{})};
  BodyMemory memory;
  const double load = lowered(body, objects, 3e-3, memory).command.elastic.z();
  const double aside = 0.8 * kStatic * load / body.coupling().stiffness;
  Pose hand{Vec3(aside, 0, 0.0071), kUpright};
  for (int i = 0; i < 50; ++i) step(body, objects, hand, memory);
  const Pose held = memory.pose;
  EXPECT_LT(std::abs(held.position.x()), 0.1 * aside);  // The tool tilts.
  for (int i = 0; i < 3000; ++i) step(body, objects, hand, memory);
  EXPECT_EQ(memory.pose.position, held.position);
  EXPECT_EQ(memory.pose.orientation.coeffs(), held.orientation.coeffs());
  // A trembling hand must move the tool by less than the tremble, for any length of time.
  for (int i = 0; i < 3000; ++i) {
    hand.position.x() = aside + (i % 2 == 0 ? 1e-5 : -1e-5);
    step(body, objects, hand, memory);
  }
  EXPECT_LT((memory.pose.position - held.position).norm(), 2e-6);
}

// In a corner two faces hold the tool. Each has its own load.
TEST(BodyFriction, AlongAnEdgeBothFacesHold) {
  const BodyTool body = tool(2000);
  const std::vector<Object> objects = {rough(Plane{}),
                                       rough(Box{Vec3(0.01, 0.5, 0.1)}, Vec3(0.04, 0, 0))};
  BodyMemory memory;
  BodyStep last;
  for (int i = 0; i <= 1500; ++i) {
    const double in = 2e-3 * std::min(1.0, i / 100.0);
    last = step(body, objects, {Vec3(in, 1e-4 * i, 0.01 - in), kUpright}, memory);
  }
  const double load = last.command.elastic.z() - last.command.elastic.x();
  ASSERT_GT(-last.command.elastic.x(), 0.3);
  EXPECT_NEAR(-last.command.force().y(), kDynamic * load, 0.06 * kDynamic * load);
  EXPECT_EQ(last.touched().size(), 2u);
}

Object any_material(Object o, test::Random& random) {
  o.material.dynamic_friction = random.uniform(0.0, 1.0);
  o.material.static_friction = o.material.dynamic_friction * random.uniform(1.0, 2.0);
  o.material.damping = random.chance(0.5) ? random.uniform(0.0, 20.0) : 0.0;
  o.material.viscous_friction = random.chance(0.5) ? random.uniform(0.0, 20.0) : 0.0;
  return o;
}

// For any movement, the stored energy must come from the hand. Friction and damping must never give
// energy.
TEST(BodyFriction, NoMotionGainsEnergy) {
  const BodyTool body = tool(300, {.stiffness = 2000.0});
  test::Random random(3);
  for (int run = 0; run < 8; ++run) {
    const std::vector<Object> objects = {
        any_material(object(grid_of(Sphere{0.03}, 2e-3)), random),
        any_material(object(Plane{}, Vec3(0, 0, -0.02)), random),
        any_material(object(Box{Vec3(0.02, 0.02, 0.02)}, Vec3(0.04, 0, 0)), random)};
    BodyMemory memory;
    Pose device{Vec3(0, 0, 0.039), kUpright};
    BodyStep last = step(body, objects, device, memory);
    double touched = 0.0, taken = 0.0;
    for (int i = 0; i < 1000; ++i) {
      const Pose before = device;
      device = moved(device, random.vector(-6.0, -2.5), random.vector(-4.0, -1.0));
      if (device.position.norm() > 0.05) device = before;
      const double worked = test::coupling_energy(body, memory.pose, device) -
                            test::coupling_energy(body, memory.pose, before);
      const BodyStep now = step(body, objects, device, memory);
      EXPECT_LE(now.stored, last.stored + worked + 1e-12) << run << " " << i;
      EXPECT_GE(now.stored, 0.0);
      taken += last.stored + worked - now.stored;
      touched += static_cast<double>(now.touching);
      Vec6 rest;
      rest << now.command.force(), now.command.torque;
      for (const ObjectWrench& part : now.touched()) rest -= part.wrench;
      if (now.touched().empty()) rest.setZero();
      EXPECT_LE(rest.norm(), 1e-12) << run << " " << i;
      last = now;
    }
    EXPECT_GT(touched, 1000.0);
    EXPECT_GT(taken, 0.0);
  }
}

TEST(BodyFriction, DampingPushesAgainstTheWayInAndNeverPulls) {
  const BodyTool body = tool(1000, {.stiffness = 1e4, .max_force = 1000.0});
  Object damped = object(Plane{});
  damped.material.damping = 10.0;
  const std::vector<Object> objects = {damped}, plain = {object(Plane{})};
  BodyMemory memory, other;
  lowered(body, objects, 1e-3, memory);
  lowered(body, plain, 1e-3, other);
  constexpr double kSpeed = 0.05;
  double z = 0.0091;
  for (int i = 0; i < 40; ++i) {
    z -= kSpeed * 1e-3;
    const Command a = step(body, objects, {Vec3(0, 0, z), kUpright}, memory).command;
    const Command b = step(body, plain, {Vec3(0, 0, z), kUpright}, other).command;
    if (i <= 5) continue;
    // The damping also acts on the sides below the floor. The compliance of the coupling counts
    // twice.
    const double share = 1e4 / (1e4 + kStiffness);
    const double expected =
        10.0 * kSpeed * (1.0 + test::kRound * (0.01 - z) / kFace) * share * share;
    EXPECT_NEAR(a.force().z() - b.force().z(), expected, 0.08 * expected) << i;
  }
  for (const double speed : {0.01, 0.2, 2.0}) {
    BodyMemory leaving = memory;
    for (int i = 1; i < 100; ++i)
      EXPECT_GE(step(body, objects, {Vec3(0, 0, z + speed * 1e-3 * i), kUpright}, leaving)
                    .command.force()
                    .z(),
                -4e-2)
          << speed << " " << i;
  }
}

TEST(BodyFriction, ViscosityIsByTheSpeed) {
  const BodyTool body = tool(1000);
  Object oily = object(Plane{});
  oily.material.viscous_friction = 5.0;
  const std::vector<Object> objects = {oily};
  for (const double speed : {0.02, 0.1}) {
    BodyMemory memory;
    lowered(body, objects, 3e-3, memory);
    Command c;
    for (int i = 1; i <= 300; ++i)
      c = step(body, objects, {Vec3(speed * 1e-3 * i, 0, 0.0071), kUpright}, memory).command;
    EXPECT_NEAR(c.force().x(), -5.0 * speed, 0.02 * 5.0 * speed) << speed;
  }
}

// A belt below a resting hand must pull it. A hand that moves with the belt must feel nothing.
TEST(BodyFriction, WhatMovesTakesTheToolAlong) {
  const BodyTool body = tool(1000);
  const std::vector<Object> objects = {rough(Plane{})};
  for (const double speed : {1e-3, 0.1}) {  // [m/s] speed of the belt
    const ObjectMotion belt{.linear = Vec3(1e-3 * speed, 0, 0)};
    BodyMemory still, along;
    const double load = lowered(body, objects, 3e-3, still).command.elastic.z();
    along = still;
    Command at_rest, with;
    for (int i = 1; i <= 4000; ++i) {
      still.known = along.known = false;
      at_rest =
          step_body(body, objects, {Vec3(0, 0, 0.0071), kUpright}, 1e-3, still, {&belt, 1}).command;
      with = step_body(body, objects, {Vec3(1e-3 * speed * i, 0, 0.0071), kUpright}, 1e-3, along,
                       {&belt, 1})
                 .command;
      ASSERT_LE(at_rest.force().x(), 1.02 * kStatic * load);
    }
    EXPECT_GT(at_rest.force().x(), 0.95 * kDynamic * load);
    EXPECT_NEAR(with.force().x(), 0.0, 0.01 * load);
  }
}

TEST(BodyFriction, TheSameBitsAndNoAllocation) {
  const BodyTool body = tool(500);
  std::vector<Object> objects = {rough(grid_of(Sphere{0.03}, 2e-3)), rough(Plane{})};
  for (Object& o : objects) o.material.damping = o.material.viscous_friction = 2.0;
  const auto run = [&] {
    BodyMemory memory;
    Command sum;
    for (int i = 0; i < 300; ++i) {
      const double t = 0.02 * i;
      const Command c =
          step(body, objects, {Vec3(0.02 * std::sin(t), 0.0, 0.035), kUpright}, memory).command;
      sum.elastic += c.elastic;
      sum.frictional += c.frictional;
      sum.torque += c.torque;
    }
    return sum;
  };
  const Command first = test::same_twice_without_allocation(run);
  EXPECT_GT(first.frictional.norm(), 0.1);
}

}  // namespace
}  // namespace feltwire::body_friction_test
