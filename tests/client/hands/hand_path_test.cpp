#include "client/hands/hand_path.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace feltwire::hand_path_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

HandTask task(HandPath path) {
  HandTask t;
  t.path = path;
  t.center = {1.0, 2.0, 3.0};
  t.radius = 0.03;
  t.frequency = 0.5;
  t.depth = 0.01;
  t.clearance = 0.02;
  t.lead_in = 0.5;
  return t;
}

TEST(HandPath, PressBeginsOutsideAndEndsAtDepth) {
  const IntendedMotion motion(task(HandPath::press));
  EXPECT_NEAR(motion.position(0.0).z(), 3.02, 1e-15);
  EXPECT_NEAR(motion.position(0.5).z(), 2.99, 1e-15);
  EXPECT_NEAR(motion.position(7.0).z(), 2.99, 1e-15);
}

TEST(HandPath, SlideFollowsTheSineAlong) {
  HandTask t = task(HandPath::slide);
  t.normal = Vec3::UnitY();
  t.along = {2.0, 5.0, 0.0};  // Only the part perpendicular to the normal counts.
  const IntendedMotion motion(t);
  for (const double time : {0.7, 1.0, 1.3, 2.9}) {
    const Vec3 p = motion.position(time);
    EXPECT_NEAR(p.x(), 1.0 + 0.03 * std::sin(std::numbers::pi * time), 1e-15);
    EXPECT_NEAR(p.y(), 1.99, 1e-15);
    EXPECT_NEAR(p.z(), 3.0, 1e-15);
  }
}

TEST(HandPath, OrbitAboutABallComesInFromOutsideTheCircle) {
  HandTask t = task(HandPath::orbit);
  t.depth = 0.0;
  const IntendedMotion motion(t);
  EXPECT_NEAR((motion.position(0.0) - t.center).norm(), 0.05, 1e-15);
  for (const double time : {0.5, 0.9, 1.7}) {
    EXPECT_NEAR((motion.position(time) - t.center).norm(), 0.03, 1e-15);
    EXPECT_NEAR(motion.position(time).z(), 3.0, 1e-15);
  }
}

TEST(HandPath, AStrikeComesInAtItsSpeedAndStays) {
  HandTask t = task(HandPath::strike);
  t.speed = 0.8;
  const IntendedMotion motion(t);
  EXPECT_NEAR(motion.position(0.0).z(), 3.0 + 0.02 + 0.8 * 0.5 / 2.0, 1e-15);
  const auto speed = [&](double at) {
    return (motion.position(at).z() - motion.position(at + 1e-6).z()) / 1e-6;
  };
  EXPECT_NEAR(speed(0.0), 0.0, 1e-4) << "from rest";
  EXPECT_NEAR(speed(0.25), 0.4, 1e-5);
  EXPECT_NEAR(speed(0.5), 0.8, 1e-6);
  EXPECT_NEAR(motion.position(0.5 + 0.02 / 0.8).z(), 3.0, 1e-15) << "at the surface";
  EXPECT_NEAR(speed(0.5 + 0.02 / 0.8), 0.8, 1e-6);
  EXPECT_NEAR(motion.position(2.0).z(), 2.99, 1e-15);
}

TEST(HandPath, FigureEightCrossesItsCentreTwiceATurn) {
  const IntendedMotion motion(task(HandPath::figure_eight));
  const Vec3 at_center{1.0, 2.0, 2.99};
  EXPECT_LT((motion.position(1.0) - at_center).norm(), 1e-15);
  EXPECT_LT((motion.position(2.0) - at_center).norm(), 1e-15);
  EXPECT_NEAR((motion.position(1.5) - at_center).norm(), 0.03, 1e-15);
}

TEST(HandPath, TapsSwingBetweenClearanceAndDepth) {
  const IntendedMotion motion(task(HandPath::taps));
  EXPECT_NEAR(motion.position(0.0).z(), 3.02, 1e-15);
  EXPECT_NEAR(motion.position(1.0).z(), 2.99, 1e-15);
  EXPECT_NEAR(motion.position(2.0).z(), 3.02, 1e-15);
}

TEST(HandPath, TremorHasItsRmsAndItsSeed) {
  HandTask t = task(HandPath::press);
  t.tremor = 1e-4;
  t.seed = 7;
  const IntendedMotion motion(t), same(t);
  t.seed = 8;
  const IntendedMotion other(t);
  double squares = 0.0, difference = 0.0;
  constexpr int kCount = 200000;
  for (int n = 0; n < kCount; ++n) {
    const double time = 1.0 + n * 1e-3;
    const Vec3 p = motion.position(time);
    EXPECT_EQ(p, same.position(time));
    squares += (p - Vec3(1.0, 2.0, 2.99)).squaredNorm();
    difference += (p - other.position(time)).norm();
  }
  EXPECT_NEAR(std::sqrt(squares / (3 * kCount)), 1e-4, 0.1e-4);
  EXPECT_GT(difference / kCount, 0.5e-4);
}

TEST(HandPath, BadTasksSayWhatIsWrong) {
  HandTask t = task(HandPath::slide);
  t.along = t.normal;
  EXPECT_THAT([&] { IntendedMotion m(t); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("parallel")));
  t = task(HandPath::slide);
  t.depth = std::nan("");
  EXPECT_THAT([&] { IntendedMotion m(t); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("not finite")));
  EXPECT_THAT([] { hand_path("circle"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("figure-eight")));
}

}  // namespace
}  // namespace feltwire::hand_path_test
