// A hand leads the simulated arm over sealed datagrams and an emulated link. It presses on a table,
// slides along the table, and lifts a box.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "client/simulated_robots/arm.hpp"
#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::teleoperation_arm_test {
namespace {

using enum LinkState;

constexpr double kTable = 0.3;  // [m] scenes/arm/table.xml
// The arm's spring of 1000 N/m and the table's of 5000 N/m, in series.
constexpr double kSeries = 1000.0 * 5000.0 / 6000.0;
constexpr double kHand = 300.0;    // [N/m] stiffness of the simulated hand
constexpr double kFriction = 0.3;  // mu of the table

ArmConfig in_scene(const char* name) {
  ArmConfig config;
  config.file = std::string(FELTWIRE_SOURCE_DIR "/scenes/arm/") + name;
  return config;
}

struct ArmAtHeight {
  ArmAtHeight(const char* file, double height) : arm(in_scene(file)) {
    Nanoseconds now = test::RobotSession::kStart - std::chrono::seconds(4);
    bring(arm, Vec3(0.45, 0.0, height), arm.spec().gripper_opening, now);
  }
  Arm arm;
};

struct ArmSession : ArmAtHeight, test::RobotSession {
  explicit ArmSession(const std::string& link, const char* file = "table.xml",
                      double height = kTable + 0.02)
      : ArmAtHeight(file, height), RobotSession(arm, link) {}
  double box() const { return arm.place_of("box").value().z(); }  // [m] height of the box

  /// Returns the largest force [N] on the tool while the hand's target moves by `way` and then
  /// stays.
  double peak_of(const Vec3& way, double time, double rest) {
    double peak = 0.0;
    const Vec3 from = hand.meant;
    for (double t = 0.0; t < time + rest; t += 1e-3) {
      const double s = std::min(1.0, t / time);
      hand.meant = from + (s * s * (3.0 - 2.0 * s)) * way;
      tick();
      peak = std::max(peak, arm.contact_force().norm());
    }
    return peak;
  }
  /// Returns the force [N] of the springs in series, for the hand's target minus its offset.
  double intended(double began) const {
    const double deep = began + servo.lead()->offset.z() - hand.meant.z() - 0.02;
    return deep / (1.0 / kHand + 1.0 / kSeries);
  }
};

void press_and_slide(const std::string& link) {
  ArmSession bench(link);
  bench.engage();
  ASSERT_EQ(bench.state(), engaged);
  const double began = bench.hand.meant.z();
  const double pressed = bench.peak_of(Vec3(0.0, 0.0, -0.06), 3.0, 1.0);
  const double intended = bench.intended(began);
  EXPECT_GE(intended, 5.0);
  EXPECT_LE(pressed, 1.5 * intended);
  const double hand = bench.force(), arm = bench.arm.contact_force().z();
  EXPECT_GE(hand, 3.0);
  EXPECT_NEAR(hand, arm, 0.2 * arm);
  EXPECT_NEAR(bench.servo.remote()->remote().contact.stiffness, kSeries, 0.05 * kSeries);

  const double x = bench.arm.read(bench.now).pose.position.x();
  const double slid = bench.peak_of(Vec3(0.08, 0.0, 0.0), 3.0, 0.5);
  EXPECT_LE(slid, 1.5 * intended * std::hypot(1.0, kFriction));
  EXPECT_GE(bench.arm.read(bench.now).pose.position.x() - x, 0.065);
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_FALSE(bench.arm.read(bench.now).stopped);
}

TEST(TeleoperationArm, PressesAndSlides) { press_and_slide("delay=0"); }

TEST(TeleoperationArm, PressesAndSlidesOverADelayAndLoss) {
  for (const char* seed : {"1", "2", "3"}) {
    SCOPED_TRACE(seed);
    // two links with a round trip of 100 ms
    press_and_slide(std::string("delay=25,loss=2,seed=") + seed);
  }
}

TEST(TeleoperationArm, LiftsABoxOverADelayAndLoss) {
  constexpr double kBox = 0.22;                  // [m] scenes/arm/box.xml
  constexpr double kOpen = 0.08, kGrips = 0.03;  // [m]
  ArmSession bench("delay=25,loss=2,seed=1", "box.xml", kBox + 0.055);
  bench.hand.gripper = kOpen;
  bench.engage();
  ASSERT_EQ(bench.state(), engaged);
  bench.move(Vec3(0.0, 0.0, -0.05), 1.0);
  bench.hand.gripper = kGrips;
  bench.run(1.0);
  const double before = bench.box();
  bench.move(Vec3(0.0, 0.0, 0.06), 1.5);
  bench.run(1.0);
  EXPECT_NEAR(bench.box() - before, 0.06, 0.015);
  const Remote& told = bench.servo.remote()->remote();
  EXPECT_GT(told.gripper, kGrips) << "the box is between the fingers";
  EXPECT_GT(told.gripper_force, 5.0);
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_FALSE(bench.arm.read(bench.now).stopped);

  // The hand releases the switch and then the lever. The box must stay in place.
  const double held = bench.box();
  bench.hand.pressed = false;
  bench.run(0.3);
  bench.hand.gripper = kOpen;
  bench.run(0.5);
  EXPECT_NEAR(bench.box(), held, 0.01);
  // The hand engages again with the lever open. The gripper must open without a jump.
  bench.hand.pressed = true;
  double opening = bench.follower.wanted().gripper, fastest = 0.0;
  for (int n = 0; n < 3500; ++n) {
    bench.tick();
    fastest = std::max(fastest, bench.follower.wanted().gripper - opening);
    opening = bench.follower.wanted().gripper;
  }
  EXPECT_LE(fastest, GripperLimits{}.catch_up * 1e-3 * (1.0 + 1e-9));
  EXPECT_NEAR(opening, kOpen, 1e-6);
}

}  // namespace
}  // namespace feltwire::teleoperation_arm_test
