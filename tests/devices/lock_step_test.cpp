// Devices answer each command. Tests the force that the driver assumes when a new command did not
// reach the device.

#include "client/device/lock_step.hpp"

#include <gtest/gtest.h>

#include "core/device/device_spec.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire::lock_step_test {
namespace {

/// Answers at once and holds the last command.
class Obedient final : public LockStepDevice {
 public:
  explicit Obedient(const char* spec = "simulated") : Obedient(builtin_device(spec)) {}
  explicit Obedient(const DeviceSpec& spec) : LockStepDevice({.spec = spec, .sources = {}}, {}) {}
  Command held;
  bool blocked = false;  // Sending fails.

 private:
  std::optional<Command> send(const Command& command) noexcept override {
    if (blocked) return std::nullopt;
    held = command;
    return command;
  }
  Answer answer(const Command&, DeviceReading&, Nanoseconds) noexcept override {
    return Answer::whole;
  }
  bool forget() noexcept override { return true; }
  void let_go() noexcept override {}
};

TEST(LockStep, ItsForcesAreOneTickLateAndItHasNoRotation) {
  const DeviceSpec all = builtin_device("sigma.7");
  ASSERT_NE(all.rotation_actuated, 0);
  const Obedient device("sigma.7");
  EXPECT_EQ(device.spec().actuation.late_ticks, 1);
  EXPECT_EQ(device.spec().rotation_sensed, 0);
  EXPECT_EQ(device.spec().rotation_actuated, 0);
  EXPECT_EQ(device.spec().max_torque, 0.0);
  EXPECT_EQ(device.spec().max_force, all.max_force);
}

TEST(LockStep, ALagOfItsMotorsStandsBesideItsLateTick) {
  DeviceSpec spec = builtin_device("falcon");
  EXPECT_EQ(Obedient(spec).spec().actuation.lag, 0.0);
  spec.actuation.late_ticks = 0;
  spec.actuation.lag = 2e-4;
  const Obedient device(spec);
  EXPECT_EQ(device.spec().actuation.lag, 2e-4);
  EXPECT_EQ(device.spec().actuation.late_ticks, 1);
}

TEST(LockStep, ZeroIsSentAgainUntilItGoesOut) {
  const Command pull{.elastic = Vec3(0, 0, 2)};
  Obedient device;
  const auto tick = [&device] { return device.await_tick(monotonic_now()); };
  ASSERT_TRUE(tick());
  device.write(pull);
  ASSERT_TRUE(tick());
  EXPECT_EQ(device.held, pull);
  device.blocked = true;
  device.write({.elastic = Vec3(0, 0, 1)});  // The device holds the earlier force.
  EXPECT_FALSE(tick());
  EXPECT_EQ(device.write({}), Command{});  // The zero is lost too.
  EXPECT_EQ(device.held, pull);
  device.blocked = false;
  device.write({});
  EXPECT_EQ(device.held, Command{});
}

}  // namespace
}  // namespace feltwire::lock_step_test
