#include "client/hands/wrist_path.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace feltwire::wrist_path_test {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

HandTask tilted_slide() {
  HandTask task;
  task.path = HandPath::slide;
  task.normal = Vec3(0.0, 3.0, 4.0);
  task.along = Vec3(1.0, 1.0, 0.0);
  task.frequency = 0.5;
  task.lead_in = 0.5;
  return task;
}

TEST(WristPath, EveryTurnBeginsAtNothingAndGrowsWithoutAJump) {
  for (int path = 0; path < static_cast<int>(kWristPathNames.size()); ++path) {
    const IntendedTurn turn({static_cast<WristPath>(path), 0.6}, tilted_slide());
    Vec3 before = turn.rotation(0.0);
    EXPECT_EQ(before, Vec3::Zero());
    for (int ms = 1; ms <= 4000; ++ms) {
      const Vec3 now = turn.rotation(1e-3 * ms);
      // The speed is at most angle * (2 pi f of the path + 3/2 / lead_in).
      ASSERT_LE((now - before).norm(), 1e-3 * 0.6 * (kTurn * 0.5 + 3.0) + 1e-12);
      ASSERT_LE(now.norm(), 0.6 + 1e-12);
      before = now;
    }
  }
}

TEST(WristPath, AxesAreThoseOfTheHandsPath) {
  const HandTask task = tilted_slide();
  const Vec3 normal = task.normal.normalized();
  const auto at = [&](WristPath path, double t) {
    return IntendedTurn({path, 0.6}, task).rotation(t);
  };
  EXPECT_EQ(at(WristPath::still, 1.3), Vec3::Zero());
  const double quarter = 2.5;  // [s] time at which the phase angle is 2 pi + pi / 2
  EXPECT_NEAR((at(WristPath::screwdriver, quarter) - 0.6 * normal).norm(), 0.0, 1e-12);
  for (const WristPath path : {WristPath::tilt, WristPath::scrape, WristPath::roll})
    for (const double t : {0.7, 1.0, 1.9, 2.6}) EXPECT_NEAR(at(path, t).dot(normal), 0.0, 1e-12);
  for (const double t : {0.7, 1.0, 1.9, 2.6})
    EXPECT_NEAR(at(WristPath::tilt, t).norm(), 0.6, 1e-12) << "the lean goes round, all of it";
}

TEST(WristPath, AToolRollsAsFarAsTheHandSlides) {
  HandTask task = tilted_slide();
  task.depth = task.clearance = 0.0;
  const IntendedMotion motion(task);
  const double angle = 1.5;
  const IntendedTurn turn({WristPath::roll, angle}, task);
  const double radius = task.radius / angle;  // [m] radius of the rolling tool
  const Vec3 normal = task.normal.normalized();
  for (const double t : {0.6, 0.9, 1.4, 2.2}) {
    const Vec3 way = motion.position(t) - task.center;
    // Rolling without slip: the lowest point of the roller, `radius` below its axis, moves by way +
    // turn x (-r n).
    const Vec3 slip = way + turn.rotation(t).cross(Vec3(-radius * normal));
    EXPECT_NEAR(slip.norm(), 0.0, 1e-12) << t;
  }
}

TEST(WristPath, ItWaitsInTheAirAsTheHandDoes) {
  HandTask task = tilted_slide();
  task.air = 2.0;
  const IntendedTurn turn({WristPath::tilt, 0.4}, task);
  EXPECT_EQ(turn.rotation(1.99), Vec3::Zero());
  EXPECT_GT(turn.rotation(2.4).norm(), 0.1);
}

TEST(WristPath, RefusesWhatIsNoTurn) {
  for (const double angle : {4.0, -3.2, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(IntendedTurn({WristPath::tilt, angle}, {}), std::invalid_argument) << angle;
  EXPECT_THAT([] { wrist_path("wave"); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("screwdriver")));
}

}  // namespace
}  // namespace feltwire::wrist_path_test
