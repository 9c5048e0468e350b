#include "client/hands/pointer_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace feltwire::pointer_device_test {
namespace {

using std::chrono::milliseconds;

/// A hand that follows a pointer, without friction and encoder quantization. The hand starts at the
/// origin.
struct Pointed {
  static PointerHandOptions options() {
    PointerHandOptions o;
    o.spec = builtin_device("simulated");
    o.spec.coulomb_friction = 0.0;
    o.spec.position_resolution = 0.0;
    return o;
  }
  explicit Pointed(const PointerHandOptions& o = options()) : device(o, messages) {
    device.begin(Vec3(0, 0, -o.clearance), Vec3(0, 0, 3));
  }
  void point(const Vec3& target) {
    messages.push({.kind = PointerMessage::Kind::to, .target = target});
  }
  /// Runs a tick of 1 ms against a wall at z = 0 with this stiffness [N/m]. Zero means no wall.
  DeviceReading tick(double stiffness = 0.0) {
    const DeviceReading reading = device.read(milliseconds(++ms));
    force = stiffness * std::max(0.0, -reading.pose.position.z());
    device.write({Vec3(0, 0, force), Vec3::Zero(), Vec3::Zero()});
    return reading;
  }
  Ring<PointerMessage> messages{64};
  PointerDevice device;
  int ms = 0;
  double force = 0.0;  // [N] force of the wall
};

TEST(PointerDevice, BeginsBeforeTheSurface) {
  const Pointed pointed;
  EXPECT_NEAR(pointed.device.start().norm(), 0.0, 1e-12);
  EXPECT_NEAR(pointed.device.true_position().norm(), 0.0, 1e-12);
}

TEST(PointerDevice, GoesToTheTargetAtALimitedSpeedHoweverFarItJumps) {
  Pointed pointed;
  const Vec3 target(0.3, -0.2, 0.1);
  double fastest = 0.0;
  for (int i = 0; i < 3000; ++i) {
    pointed.point(target);
    pointed.tick();
    fastest = std::max(fastest, pointed.device.true_velocity().norm());
  }
  EXPECT_NEAR((pointed.device.true_position() - target).norm(), 0.0, 1e-6);
  EXPECT_GT(fastest, 0.4);
  EXPECT_LT(fastest, 0.7);  // [m/s] 0.5 m/s and the overshoot of the arm
}

TEST(PointerDevice, PressesWithTheReachOfItsSpringAtMost) {
  Pointed pointed;
  double sum = 0.0;
  for (int i = 0; i < 4000; ++i) {
    pointed.point(Vec3(0, 0, -5.0));
    pointed.tick(2000.0);
    if (i >= 2000) sum += pointed.force;
  }
  EXPECT_NEAR(sum / 2000, 300.0 * 0.02, 0.5);  // The hand oscillates on a wall without a bound.
}

TEST(PointerDevice, LetsGoWhenItIsToldNothing) {
  Pointed pointed;
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(pointed.tick().ended);  // The start allows 5 s.
  pointed.point(Vec3::Zero());
  for (int i = 0; i < 800; ++i) EXPECT_FALSE(pointed.tick().ended);
  pointed.point(Vec3::Zero());  // A new pointer position restarts the time.
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(pointed.tick().ended) << i;
  for (int i = 0; i < 3; ++i) pointed.tick();
  EXPECT_TRUE(pointed.tick().ended);
  EXPECT_TRUE(pointed.device.neglected());
  pointed.point(Vec3::Zero());  // This position comes too late.
  EXPECT_TRUE(pointed.tick().ended);
}

TEST(PointerDevice, LetsGoWhenItIsToldTo) {
  Pointed pointed;
  pointed.tick();
  pointed.messages.push({.kind = PointerMessage::Kind::let_go});
  EXPECT_TRUE(pointed.tick().ended);
  EXPECT_FALSE(pointed.device.neglected());
}

TEST(PointerDevice, StaysWhereTheTargetIsNoPlace) {
  Pointed pointed;
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  constexpr double kForever = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 400; ++i) {
    pointed.point(Vec3(kNothing, 0, 0));
    pointed.point(Vec3(0, kForever, 0));
    EXPECT_FALSE(pointed.tick().ended);
  }
  EXPECT_NEAR(pointed.device.true_position().norm(), 0.0, 1e-12);
  const Vec3 place(0.0, 0.01, 0.0);  // Invalid targets must have no later effect.
  for (int i = 0; i < 2000; ++i) {
    pointed.point(place);
    pointed.tick();
  }
  EXPECT_NEAR((pointed.device.true_position() - place).norm(), 0.0, 1e-6);
}

TEST(PointerDevice, RefusesNumbersThatAreOfNoUse) {
  Ring<PointerMessage> messages(4);
  for (double PointerHandOptions::*field :
       {&PointerHandOptions::speed, &PointerHandOptions::reach, &PointerHandOptions::smoothing,
        &PointerHandOptions::patience, &PointerHandOptions::beginning,
        &PointerHandOptions::clearance})
    for (const double wrong : {0.0, -1.0, std::nan("")}) {
      PointerHandOptions options = Pointed::options();
      options.*field = wrong;
      EXPECT_THROW(PointerDevice(options, messages), std::invalid_argument) << wrong;
    }
}

}  // namespace
}  // namespace feltwire::pointer_device_test
