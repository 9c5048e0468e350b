// Tests robots that are slower than the hand, and robots with a drifting clock.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::teleoperation_rate_test {
namespace {

using test::Teleoperation;
using enum LinkState;

// [N/m] the robot's spring and the wall's, in series
constexpr double kSeries = 1000.0 * 2000.0 / 3000.0;
constexpr double kSpeed = 0.25;  // [m/s] speed limit of the target

/// Engages, follows in free space, presses 25 mm deep and comes out, with a round trip of 40 ms.
void leads(double period, double drift) {
  SCOPED_TRACE("period " + std::to_string(period) + " s, drift " + std::to_string(drift));
  Teleoperation bench("delay=10,loss=1,seed=5", {}, {.per_contact = 0.0, .power = 0.0},
                      {.servo_period = period});
  bench.drift = drift;
  bench.engage();
  ASSERT_EQ(bench.state(), engaged);
  const Vec3 robot = bench.robot.position(), hand = bench.hand.true_position();
  bench.move(Vec3(0.03, 0.02, 0.0), 1.0);
  bench.run(0.5);
  const Vec3 moved = bench.hand.true_position() - hand;
  EXPECT_LE((bench.robot.position() - robot - moved).norm(), 2e-4);
  bench.move(Vec3(0.0, 0.0, -0.045), 0.6);
  bench.run(1.4);
  const double surface =
      bench.servo.remote()->remote().contact.point.z() + bench.servo.lead()->offset.z();
  const double shown = bench.force() / (surface - bench.hand.true_position().z());
  EXPECT_NEAR(shown / kSeries, 1.0, 0.05);
  EXPECT_GE(bench.force(), 3.0);
  EXPECT_NEAR(bench.force(), bench.robot.force().z(), 0.1 * bench.force());
  bench.move(Vec3(0.0, 0.0, 0.045), 0.6);
  bench.run(0.5);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_EQ(bench.state(), engaged) << "no sample was missed for a tenth of a second";
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_LE(bench.farthest_step, kSpeed * period * (1.0 + 1e-9));
}

TEST(TeleoperationRate, ARobotOfAHundredHertz) { leads(0.01, 0.0); }
TEST(TeleoperationRate, ARobotOfFiveHundredHertz) { leads(0.002, 0.0); }

/// A drift of ten thousand times a quartz's drift must reveal an error.
TEST(TeleoperationRate, ARobotWhoseClockDrifts) {
  for (const double drift : {-0.01, -1e-4, 1e-4, 0.01}) leads(0.001, drift);
  for (const double drift : {-0.01, 0.01}) leads(0.002, drift);
}

/// The robot's own clock measures the silence. The robot must hold within a tenth of a second.
TEST(TeleoperationRate, ASlowRobotHoldsWhenTheServerIsSilent) {
  for (const double period : {0.002, 0.01}) {
    Teleoperation bench("delay=0", {}, {.per_contact = 0.0, .power = 0.0},
                        {.servo_period = period});
    bench.engage();
    bench.robot_cut = true;
    bench.run(0.1 + 2.0 * period);
    EXPECT_FALSE(bench.follower.follows());
    EXPECT_EQ(bench.state(), fault);
  }
}

}  // namespace
}  // namespace feltwire::teleoperation_rate_test
