// Tests sessions of hands that use gamepads and 3D mice.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/devices/joystick_hand.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::steered_session_test {
namespace {

using testing::kFull;
using testing::kTick;
using testing::Steered;

struct Session : Steered {
  /// Pushes down into the wall.
  void press() { push(ABS_RY, kFull); }
  void run(Servo& servo, double time) {
    for (double t = 0.0; t < time; t += kTick) {
      input.deliver();
      wall.tick(*device, servo);
    }
  }
  testing::WallSession wall{.period = kTick};
};

TEST_F(Session, TheWallHoldsTheToolAndTheArmPressesNoHarderThanItReaches) {
  gamepad();
  Servo servo(device->spec(), testing::session_of(*device), {});
  run(servo, 0.1);
  for (int n = 0; n < 40; ++n) {
    push(ABS_RY, kFull - n);
    run(servo, 0.1);
  }
  EXPECT_EQ(servo.statistics().device.faults, 0u);
  EXPECT_GT(servo.held().force().z(), 2.0);
  EXPECT_LT(servo.statistics().max_force, 300.0 * 0.02 + 2.0);
  EXPECT_GT(device->true_position().z(), -0.01);
  push(ABS_RY, -kFull);
  run(servo, 1.0);
  EXPECT_EQ(servo.held(), Command{});
}

TEST_F(Session, AnUnpluggedOneIsAFaultForGood) {
  gamepad();
  Servo servo(device->spec(), testing::session_of(*device), {});
  input.key(BTN_TR, true);
  run(servo, 0.1);
  press();
  run(servo, 1.0);
  ASSERT_GT(servo.held().force().z(), 0.5);
  input.unplug();
  for (int n = 0; n < 50; ++n) wall.tick(*device, servo);
  EXPECT_EQ(servo.statistics().device.faults, 50u);
  EXPECT_EQ(servo.held(), Command{});
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
  const DeviceReading reading = device->read(wall.now);
  EXPECT_FALSE(reading.ok);
  EXPECT_FALSE(reading.deadman);
}

/// A person moves restlessly for a minute at a late wall. Returns the largest excess [J] of the
/// true motion's energy over the dissipated energy.
double made_in_a_minute(Session& session, std::string_view mode, ServoStatistics& statistics) {
  JoystickDevice& device = session.spacemouse();
  const DeviceSpec& spec = device.spec();
  SessionParameters parameters = testing::session_of(device);
  parameters.mode = mode;
  Servo servo(spec, parameters, {});
  std::mt19937 random(3);
  std::uniform_int_distribution<int> anywhere(-350, 350);
  double delivered = 0.0, burned = 0.0, most = 0.0;
  Vec3 before = device.true_position();
  Command held;
  for (int tick = 0; tick < 60000; ++tick) {
    if (tick > 10 && tick % 150 == 0) {
      for (unsigned code = ABS_X; code <= ABS_RZ; ++code)
        session.input.axis(code, anywhere(random));
      // The wall is below.
      session.input.axis(ABS_Z, anywhere(random) / 2 + 120 * (tick / 3000 % 2 == 0 ? 1 : -1));
      session.input.report();
    }
    session.input.deliver();
    session.wall.tick(device, servo);
    const Vec3 moved = device.true_position() - before;
    before = device.true_position();
    delivered += held.force().dot(moved);
    burned += spec.damping.quadratic(moved) / kTick + spec.coulomb_friction * moved.lpNorm<1>();
    most = std::max(most, delivered - burned);
    held = servo.held();
  }
  statistics = servo.statistics();
  return most;
}

TEST_F(Session, AMinuteMakesNoEnergyAndMissesNothing) {
  ServoStatistics statistics;
  EXPECT_LE(made_in_a_minute(*this, kSessionMethod, statistics), 1e-12);
  EXPECT_EQ(statistics.samples, 60000u);
  EXPECT_EQ(statistics.device.faults, 0u);
  EXPECT_GT(statistics.max_force, 1.0);
}
/// Without a bound the wall must make energy. This shows that the measurement can fail.
TEST_F(Session, TheWallAloneWouldMakeEnergy) {
  ServoStatistics statistics;
  EXPECT_GT(made_in_a_minute(*this, kUnbounded, statistics), 0.01);
}

TEST_F(Session, ATickDoesNotTouchTheHeap) {
  gamepad();
  Servo servo(device->spec(), testing::session_of(*device), {});
  run(servo, 0.1);
  for (int n = 0; n < 100; ++n) push(ABS_X, n);  // Some events are lost.
  input.deliver();
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) servo.tick(*device, wall.now += from_seconds(kTick));
  EXPECT_EQ(test::allocations() - before, 0u);
  EXPECT_GT(input.abs_asked, 0);
}

TEST_F(Session, ReleaseTakesTheForceOffForGood) {
  gamepad();
  Servo servo(device->spec(), testing::session_of(*device), {});
  run(servo, 0.1);
  press();
  run(servo, 1.0);
  ASSERT_GT(servo.held().force().z(), 0.5);
  device->release();
  run(servo, 0.1);
  EXPECT_EQ(servo.held(), Command{});
}

}  // namespace
}  // namespace feltwire::steered_session_test
