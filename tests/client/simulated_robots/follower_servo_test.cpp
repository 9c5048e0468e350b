// Tests the servo of a robot that follows: its targets, and invalid readings.

#include "core/teleoperation/follower_servo.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "client/simulated_robots/point_robot.hpp"
#include "tests/client/simulated_robots/teleoperation_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::follower_servo_test {
namespace {

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Bench {
  explicit Bench(const FollowerOptions& options = {}) : servo(robot.spec(), options) {}
  PointRobot robot{test::wall_scene(), Vec3(0.0, 0.0, 0.1)};
  FollowerServo servo;
  Nanoseconds now = std::chrono::seconds(7);
  std::uint64_t index = 0;

  RobotTarget target(const Vec3& place, LinkState state = LinkState::engaged) {
    RobotTarget t;
    t.index = ++index;
    t.sample_index = index;
    t.state = state;
    t.pose.position = place;
    return t;
  }
  RobotState tick() {
    now += kPeriod;
    return servo.tick(robot, now);
  }
};

TEST(FollowerServo, FollowsWhileEngagedAlone) {
  Bench bench;
  const Vec3 there(0.02, 0.0, 0.1);
  for (const LinkState state : {LinkState::disabled, LinkState::ready, LinkState::clutched,
                                LinkState::hold, LinkState::fault, LinkState::aligning}) {
    for (int i = 0; i < 50; ++i) {
      bench.servo.take(bench.target(there, state), bench.now);
      ASSERT_EQ(bench.tick().commanded.position, Vec3(0.0, 0.0, 0.1));
    }
  }
  for (int i = 0; i < 500; ++i) {
    bench.servo.take(bench.target(there), bench.now);
    bench.tick();
  }
  EXPECT_NEAR((bench.tick().commanded.position - there).norm(), 0.0, 1e-6);
}

TEST(FollowerServo, AnOldTargetIsNeverExecuted) {
  Bench bench;
  bench.tick();
  const RobotTarget old = bench.target(Vec3(1.0, 0.0, 0.1));
  const RobotTarget newer = bench.target(Vec3(0.0, 0.0, 0.1));
  bench.servo.take(newer, bench.now);
  for (int i = 0; i < 50; ++i) {
    bench.servo.take(old, bench.now);
    EXPECT_EQ(bench.tick().commanded.position, Vec3(0.0, 0.0, 0.1));
  }
  EXPECT_EQ(bench.servo.statistics().targets_stale, 50u);
}

TEST(FollowerServo, HoldsWithinATenthOfASecondOfSilence) {
  Bench bench;
  for (int i = 0; i < 200; ++i) {
    bench.servo.take(bench.target(Vec3(1.0, 0.0, 0.1)), bench.now);
    bench.tick();
  }
  ASSERT_TRUE(bench.servo.follows());
  for (int i = 0; i < 101; ++i) bench.tick();
  EXPECT_FALSE(bench.servo.follows());
  for (int i = 0; i < 100; ++i) bench.tick();  // The robot brakes with 5 m/s^2 from 0.25 m/s.
  const Vec3 held = bench.tick().commanded.position;
  EXPECT_EQ(bench.tick().commanded.position, held);
}

TEST(FollowerServo, AReadingThatIsNoneMovesNothing) {
  Bench bench;
  for (int i = 0; i < 100; ++i) {
    bench.servo.take(bench.target(Vec3(1.0, 0.0, 0.1)), bench.now);
    bench.tick();
  }
  const FollowerTarget held = bench.servo.step(bench.robot.read(bench.now), bench.now);
  for (int which = 0; which < 4; ++which) {
    FollowerReading reading = bench.robot.read(bench.now);
    if (which == 0) reading.pose.position.x() = kNan;
    if (which == 1) reading.force = Vec3(kNan, 0.0, 0.0);
    if (which == 2) reading.pose.orientation.coeffs().setZero();
    if (which == 3) reading.ok = false;
    bench.now += kPeriod;
    const FollowerTarget target = bench.servo.step(reading, bench.now);
    EXPECT_EQ(target.pose.position, held.pose.position) << which;
    const RobotState& said = bench.servo.report(target);
    EXPECT_FALSE(said.ok);
    EXPECT_TRUE(said.pose.position.allFinite());
  }
  EXPECT_EQ(bench.servo.statistics().faults, 4u);
}

TEST(FollowerServo, ARobotThatSensesNoForceTellsOfNoContact) {
  Bench bench;
  for (int i = 0; i < 50; ++i) {
    FollowerReading reading = bench.robot.read(bench.now);
    reading.force.reset();
    bench.now += kPeriod;
    const RobotState& said = bench.servo.report(bench.servo.step(reading, bench.now));
    EXPECT_FALSE(said.force);
    EXPECT_EQ(said.contact.surface, 0u);
    EXPECT_EQ(said.energy.given + said.energy.taken + said.energy.pushed, 0.0);
  }
}

Workspace box(const Vec3& low, const Vec3& high) {
  Workspace workspace;
  workspace.add_box(low, high);
  return workspace;
}

/// A server may send any states, numbers and engagements. The target must stay in the workspaces of
/// the robot and of the scene. It must move only along axes that neither workspace locks.
TEST(FollowerServo, NoServerDrivesItThroughItsWalls) {
  test::Random random(5);
  FollowerOptions options;
  options.workspace = box(Vec3(-0.03, -1.0, 0.05), Vec3(0.04, 1.0, 0.15));
  options.workspace.locked = {false, true, false};
  Bench bench(options);
  Workspace seat = box(Vec3(-1.0, -1.0, 0.02), Vec3(0.05, 1.0, 0.14));
  seat.turning_locked = true;
  bench.servo.sit(seat);
  const Eigen::Array3d low(-0.03, 0.0, 0.05), high(0.04, 0.0, 0.14);
  Vec3 lowest = Vec3::Constant(1.0), highest = Vec3::Constant(-1.0);
  Vec3 wanted = Vec3::Zero();
  for (int i = 0; i < 20'000; ++i) {
    if (i % 250 == 0) wanted = std::pow(10.0, random.uniform(-2.0, 2.9)) * random.direction();
    RobotTarget target = bench.target(
        wanted, random.chance(0.995) ? LinkState::engaged : static_cast<LinkState>(i % 6));
    target.pose.orientation = Quaternion(Eigen::AngleAxisd(0.5, random.direction()));
    if (i % 5000 == 4000) bench.servo.reconnected();
    if (random.chance(0.9)) bench.servo.take(target, bench.now);
    const RobotState said = bench.tick();
    const Eigen::Array3d at = said.commanded.position.array();
    ASSERT_TRUE((at >= low - 1e-9).all() && (at <= high + 1e-9).all()) << i << ": " << at;
    ASSERT_EQ(said.commanded.orientation.coeffs(), Quaternion::Identity().coeffs());
    lowest = lowest.cwiseMin(said.commanded.position);
    highest = highest.cwiseMax(said.commanded.position);
  }
  EXPECT_LE((lowest.array() - low).matrix().cwiseAbs().maxCoeff(), 1e-3) << "it went everywhere";
  EXPECT_LE((highest.array() - high).matrix().cwiseAbs().maxCoeff(), 1e-3);
}

/// The server may request any position beyond a body. The target must not enter or cross the body.
/// When the target moves freely again, it must not exceed the speed limit.
TEST(FollowerServo, NoServerDrivesItIntoABody) {
  test::Random random(6);
  FollowerOptions options;
  options.workspace = box(Vec3(-0.1, -0.1, 0.03), Vec3(0.1, 0.1, 0.2));
  options.workspace.add_body(
      {{Vec3(0.04, 0.0, 0.1), Quaternion::Identity()}, Vec3(0.0, 0.05, 0.02), 0.01});
  Bench bench(options);
  Workspace seat;
  seat.add_body({{Vec3(-0.05, 0.0, 0.1), Quaternion::Identity()}, Vec3::Zero(), 0.03});
  bench.servo.sit(seat);
  const std::array bodies{options.workspace.bodies[0], seat.bodies[0]};
  std::array<int, 2> met{};
  Vec3 wanted = Vec3::Zero(), before = bench.tick().commanded.position;
  for (int i = 0; i < 20'000; ++i) {
    if (i % 250 == 0) wanted = Vec3(0, 0, 0.1) + random.uniform(0.0, 0.2) * random.direction();
    bench.servo.take(bench.target(wanted, random.chance(0.995) ? LinkState::engaged
                                                               : static_cast<LinkState>(i % 6)),
                     bench.now);
    const Vec3 at = bench.tick().commanded.position;
    ASSERT_LE((at - before).norm(), options.motion.speed * seconds(kPeriod) * (1.0 + 1e-9)) << i;
    before = at;
    for (std::size_t n = 0; n < bodies.size(); ++n) {
      const double distance = bodies[n].wall_at(at).clearance(at);
      ASSERT_GE(distance, -1e-9) << i;
      met[n] += distance < 1e-4 ? 1 : 0;
    }
  }
  EXPECT_GE(std::min(met[0], met[1]), 100) << "both were met";
}

/// An external force pushes the robot out of its workspace. The spring must pull the robot back
/// within the limit of the target's distance.
TEST(FollowerServo, ARobotThatIsPushedOutIsPulledBackSoftly) {
  FollowerOptions options;
  options.workspace = box(Vec3(-1, -1, 0.0), Vec3(1, 1, 0.12));
  Bench bench(options);
  FollowerReading reading = bench.robot.read(bench.now);
  Pose held = reading.commanded;
  for (int i = 0; i <= 400; ++i) {
    bench.now += kPeriod;
    reading.pose.position.z() = 0.1 + 0.4 * std::min(1.0, i / 200.0);
    reading.commanded = held;
    bench.servo.take(bench.target(Vec3(0.0, 0.0, 0.5)), bench.now);
    held = bench.servo.step(reading, bench.now).pose;
    // [m] distance between target and robot
    const double pull = held.position.z() - reading.pose.position.z();
    EXPECT_LE(std::abs(pull) * bench.robot.spec().stiffness, options.leash * (1.0 + 1e-9));
    if (reading.pose.position.z() > 0.12) {
      EXPECT_LE(pull, 0.0) << "inwards";
    }
  }
}

TEST(FollowerServo, NeverAllocates) {
  Bench bench;
  bench.tick();
  const std::size_t before = test::allocations();
  for (int i = 0; i < 1000; ++i) {
    bench.servo.take(bench.target(Vec3(0.0, 0.0, -0.01)), bench.now);
    bench.tick();
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GE(bench.servo.statistics().largest_force, 1.0) << "it touched the wall, too";
}

TEST(FollowerServo, RefusesLimitsThatAreNone) {
  const PointRobot robot(test::wall_scene(), Vec3(0.0, 0.0, 0.1));
  for (const double wrong : {0.0, -1.0, kNan}) {
    FollowerOptions options;
    options.motion.speed = wrong;
    EXPECT_THROW(FollowerServo(robot.spec(), options), std::invalid_argument);
    options = {};
    options.leash = wrong;
    EXPECT_THROW(FollowerServo(robot.spec(), options), std::invalid_argument);
    FollowerSpec spec = robot.spec();
    spec.stiffness = wrong;
    EXPECT_THROW(FollowerServo{spec}, std::invalid_argument);
  }
  FollowerOptions nowhere;
  nowhere.workspace = box(Vec3(0, 0, 0), Vec3(1, 1, -0.01));
  EXPECT_THROW(FollowerServo(robot.spec(), nowhere), std::invalid_argument);
  FollowerOptions crowded;
  while (crowded.workspace.count <= Workspace::kMostGiven) crowded.workspace.add({});
  EXPECT_THROW(FollowerServo(robot.spec(), crowded), std::invalid_argument);
  for (const double radius : {0.0, -1.0, kNan}) {
    FollowerOptions sharp;
    sharp.workspace.add_body({{}, Vec3::Zero(), radius});
    EXPECT_THROW(FollowerServo(robot.spec(), sharp), std::invalid_argument);
  }
}

}  // namespace
}  // namespace feltwire::follower_servo_test
