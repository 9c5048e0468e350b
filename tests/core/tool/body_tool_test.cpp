// Compares the coupling of a tool with a body with closed forms, and tests malicious hands.

#include "core/tool/body_tool.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/bounding/bounding.hpp"
#include "core/bounding/port_energy.hpp"
#include "tests/core/bodies.hpp"
#include "tests/core/support.hpp"
#include "tests/support/same_twice.hpp"

namespace feltwire::body_tool_test {
namespace {

using test::box_shell;
using test::flat_force;
using test::grid_of;
using test::kFace;
using test::kHalf;
using test::kStiffness;
using test::object;
using test::tool;

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
    const BodyStep now = test::step(body, objects, device, memory);
    EXPECT_LT(now.command.force().norm(), 1e-5);
    EXPECT_LT(now.command.torque.norm(), 1e-6);
    EXPECT_LE(now.evaluations, 3u);
  }
}

// Coupling and contact are two springs in series. Their forces are equal up to the coupling's
// limit.
TEST(BodyTool, OnAPlaneIsTwoSpringsInARow) {
  const BodyTool body = tool(20000, {.stiffness = 500.0, .max_force = 3.0});
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  test::step(body, objects, {Vec3(0, 0, 0.011), Quaternion::Identity()}, memory);
  for (double d = 0.0; d < 0.02; d += 1e-4) {
    const Command c =
        test::step(body, objects, {Vec3(0, 0, 0.01 - d), Quaternion::Identity()}, memory).command;
    const double sunk = 0.01 - memory.pose.position.z();
    EXPECT_NEAR(c.elastic.z(), flat_force(sunk, kFace), 0.02) << d;
    EXPECT_NEAR(c.elastic.z(), std::min(3.0, 500.0 * (d - sunk)), 1e-9) << d;
    EXPECT_LT(c.torque.norm(), 2e-4);
    EXPECT_LE(c.elastic.norm(), 3.0 * (1.0 + 1e-12));
  }
}

// A hand that rotates the box on the plane gets the moment of the box's face. Coupling and contact
// are again two springs in series.
TEST(BodyTool, TurnedOnAPlaneGivesTorque) {
  const BodyTool body =
      tool(40000, {.stiffness = 1e6, .rotational_stiffness = 0.3, .max_force = 100});
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  test::step(body, objects, {Vec3(0, 0, 0.0101), Quaternion::Identity()}, memory);
  // [N m/rad] rotational stiffness of the face
  const double contact = kStiffness * 0.06 * 0.06 / 12.0;
  const double angle = 1e-3, expected = angle * 0.3 * contact / (0.3 + contact);
  Command c;
  for (int i = 0; i < 20; ++i)
    c = test::step(body, objects,
                   {Vec3(0, 0, 0.01 - 2e-4), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()))},
                   memory)
            .command;
  EXPECT_NEAR(c.torque.y(), -expected, 0.03 * expected);
  EXPECT_NEAR(c.elastic.z(), kStiffness * 2e-4, 0.02 * kStiffness * 2e-4);
}

TEST(BodyTool, AFastHandDoesNotTakeTheToolThroughAWall) {
  const BodyTool body = tool(2000, {.max_force = 5.0});  // The coupling deflects by 5 mm.
  // A sampled wall of 20 mm. The hand comes at 10 m/s and stops 0.3 m beyond the wall.
  const std::vector<Object> objects = {object(grid_of(Box{Vec3(0.2, 0.2, 0.01)}, 1e-3))};
  for (const double stride : {0.01, 0.6}) {  // 10 m/s, and a jump in one step
    BodyMemory memory;
    for (double z = 0.3; z > -0.3; z -= stride)
      test::step(body, objects, {Vec3(0, 0, z), Quaternion::Identity()}, memory);
    Command c;
    for (int i = 0; i < 100; ++i)
      c = test::step(body, objects, {Vec3(0, 0, -0.3), Quaternion::Identity()}, memory).command;
    EXPECT_GT(memory.pose.position.z(), 0.0) << stride;
    EXPECT_NEAR(c.elastic.z(), 5.0, 1e-9) << stride;  // the limit of the coupling
  }
}

// Only the hand can add stored energy. For any movement and rotation, a step must add no more than
// the hand's work against the coupling.
TEST(BodyTool, AStepNeverAddsEnergy) {
  const BodyTool body = tool(500, {.stiffness = 2000.0});
  const std::vector<Object> objects = {object(grid_of(Sphere{0.03}, 1e-3)),
                                       object(Plane{}, Vec3(0, 0, -0.02)),
                                       object(Box{Vec3(0.02, 0.02, 0.02)}, Vec3(0.04, 0, 0))};
  BodyMemory memory;
  test::Random random(3);
  Pose device{Vec3(0, 0, 0.04), Quaternion::Identity()};
  BodyStep last = test::step(body, objects, device, memory);
  double touched = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const Pose before = device;
    const Vec3 by = random.vector(-6.0, -2.3), turn = random.vector(-4.0, -1.0);
    device = moved(device, by, turn);
    if (device.position.norm() > 0.08) device = before;
    const double worked = test::coupling_energy(body, memory.pose, device) -
                          test::coupling_energy(body, memory.pose, before);
    const BodyStep now = test::step(body, objects, device, memory);
    EXPECT_LE(now.stored, last.stored + worked + 1e-12);
    touched += static_cast<double>(now.touching);
    last = now;
  }
  EXPECT_GT(touched, 1e3);
}

// A hand extracts as much energy as possible from the complete chain: the body, then the bound with
// rotation and torque.
TEST(BodyTool, BehindTheBoundNoHandGainsEnergy) {
  const BodyTool body = tool(300, {.stiffness = 5000.0});
  const std::vector<Object> objects = {object(grid_of(Sphere{0.03}, 1e-3)),
                                       object(Plane{}, Vec3(0, 0, -0.02))};
  BoundingConfig config = test::config("contact_frame");
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Bounding bounding(config);
    PortEnergy port(config.damping, config.rotational_damping, config.period, {}, 1e-12);
    BodyMemory memory;
    test::Random random(seed);
    Pose device{Vec3(0, 0, 0.042), Quaternion::Identity()};
    Command held;
    double largest = 0.0;
    for (int i = 0; i < 1500; ++i) {
      // The hand moves along the force, which extracts the most energy, or back in.
      Vec3 by = test::greediest(held.force(), config.period, 0.5);
      Vec3 turn = test::greediest(held.torque, config.period, 1e-3);
      if (random.chance(0.5)) by = -random.uniform(0.0, 1e-3) * device.position.normalized();
      if (random.chance(0.3)) turn = random.uniform(0.0, 0.05) * random.direction();
      device = moved(device, by, turn);
      port.step(held, by, turn, config.period);
      const Command wanted = test::step(body, objects, device, memory).command;
      held = bounding.step({by, turn, config.period, wanted}).rendered;
      largest = std::max(largest, held.torque.norm());
    }
    EXPECT_EQ(port.violations(), 0u) << seed;
    EXPECT_GT(largest, 1e-4);  // The torque must be large enough to give energy.
  }
}

TEST(BodyTool, APoseThatIsNoneGivesZeroAndIsForgotten) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const BodyTool body = tool(200);
  const std::vector<Object> objects = {object(Plane{})};
  BodyMemory memory;
  const Pose in{Vec3(0, 0, 0.009), Quaternion::Identity()};
  test::step(body, objects, {Vec3(0, 0, 0.02), Quaternion::Identity()}, memory);
  const Command before = test::step(body, objects, in, memory).command;
  EXPECT_GT(before.elastic.z(), 0.0);
  const Pose held = memory.pose;
  for (const Pose& bad :
       {Pose{Vec3(nan, 0, 0), Quaternion::Identity()},
        Pose{Vec3(0, 0, infinity), Quaternion::Identity()},
        Pose{Vec3::Zero(), Quaternion(0, 0, 0, 0)}, Pose{Vec3::Zero(), Quaternion(nan, 0, 0, 1)},
        Pose{Vec3::Constant(1e300), Quaternion(1e200, 0, 0, 1e200)}}) {
    const Command c = test::step(body, objects, bad, memory).command;
    EXPECT_TRUE(c.finite());
    if (!bad.position.allFinite() || !std::isfinite(bad.orientation.squaredNorm()) ||
        bad.orientation.squaredNorm() == 0.0) {
      EXPECT_EQ(c, Command{});
      EXPECT_EQ(memory.pose.position, held.position);
    }
  }
  const Command after = test::step(body, objects, in, memory).command;
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
      const Command c = test::step(body, objects, device, memory).command;
      sum.elastic += c.elastic;
      sum.torque += c.torque;
    }
    return sum;
  };
  const Command first = test::same_twice_without_allocation(run);
  EXPECT_GT(first.elastic.norm(), 1.0);
}

}  // namespace
}  // namespace feltwire::body_tool_test
