// Tests a protected device: a start without a kick, an emergency stop and a tool's weight.

#include "client/device/protected_device.hpp"

#include <gmock/gmock.h>

#include <random>

#include "tests/devices/mapped_handle.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::protected_device_test {
namespace {

using testing::any_mapping;
using testing::Handle;
using ::testing::HasSubstr;
using testing::kTick;
using testing::Mapped;

constexpr double kUp = 0.5;  // [s] time until the device carries the weight

/// A protected handle that only the test moves.
struct Bench {
  explicit Bench(const ProtectionOptions& options)
      : handle(new Handle), device(std::unique_ptr<Device>(handle), options, emergency) {
    handle->mass.stiffness = handle->mass.hand_damping = 0.0;
    handle->mass.tool = options.tool_weight;
    handle->mass.friction = 1e3;  // Friction keeps the handle at its position.
  }
  DeviceReading tick(const Command& command = {}) {
    now += from_seconds(kTick);
    const DeviceReading reading = device.read(now);
    told = device.write(reading.withheld == Withheld::nothing && reading.ok ? command : Command{});
    return reading;
  }
  /// Ticks until the device passes forces on. Returns the number of ticks.
  int start() {
    for (int n = 1; n < 5000; ++n)
      if (tick().withheld == Withheld::nothing) return n;
    ADD_FAILURE() << "it does not start";
    return 0;
  }
  double up() const { return handle->on_hand.force().z(); }

  std::shared_ptr<EmergencyStop> emergency = std::make_shared<EmergencyStop>();
  Handle* handle;
  ProtectedDevice device;
  Command told;
  Nanoseconds now = std::chrono::seconds(3);
};

const Command kPull{.elastic = Vec3(1.0, 2.0, 3.0)};

TEST(ProtectedDevice, WithoutOptionsEverythingIsTheDevicesBitByBit) {
  Bench bench({});
  Handle alone;
  EXPECT_EQ(bench.device.spec().max_force, alone.spec().max_force);
  EXPECT_EQ(bench.device.spec().hand_force, alone.spec().hand_force);
  EXPECT_EQ(bench.tick(kPull).withheld, Withheld::nothing);
  EXPECT_EQ(bench.handle->on_hand, kPull);
  EXPECT_EQ(bench.told, kPull);
}

/// The device must give no force while the hand moves, and for a quarter of a second after it
/// rests.
TEST(ProtectedDevice, NoForceBeforeTheHandIsStill) {
  Bench bench({.still = 0.25});
  for (int n = 0; n < 2000; ++n) {
    bench.handle->mass.position[0] = 0.02 * std::sin(0.01 * n);
    EXPECT_EQ(bench.tick(kPull).withheld, Withheld::starting);
    EXPECT_EQ(bench.handle->on_hand, Command{});
  }
  EXPECT_NEAR(bench.start() * kTick, 0.25, 0.01);
  bench.tick(kPull);
  EXPECT_EQ(bench.handle->on_hand, kPull);
}

TEST(ProtectedDevice, TheEnablingSwitchStartsAtOnce) {
  Bench bench({.still = 0.25});
  bench.tick();
  bench.handle->deadman = true;
  EXPECT_EQ(bench.start(), 1);
}

TEST(ProtectedDevice, TheWeightIsTakenUpSlowlyThenHeldAndNotTold) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> weights(0.01, 6.0);
  for (int n = 0; n < 50; ++n) {
    const double weight = weights(random);
    Bench bench({.tool_weight = weight});
    bench.handle->lag = n % 2;
    double before = 0.0;
    for (DeviceReading reading = bench.tick(); reading.withheld == Withheld::starting;
         reading = bench.tick()) {
      EXPECT_GE(bench.up(), before);
      EXPECT_LE(bench.up(), before + weight * kTick / kUp * (1.0 + 1e-9));
      before = bench.up();
    }
    for (int i = 0; i < 5; ++i) bench.tick();
    EXPECT_EQ(bench.up(), weight);
    EXPECT_EQ(bench.told, Command{});
    EXPECT_NEAR(seconds(bench.now - std::chrono::seconds(3)), kUp, 0.01);
  }
}

/// With compensation of its weight the tool must float. Without compensation it must fall.
TEST(ProtectedDevice, AToolFloats) {
  for (const double told : {0.4, 0.0}) {
    Bench bench({.tool_weight = told});
    bench.start();
    bench.handle->mass.tool = 0.4;
    bench.handle->mass.friction = 0.0;
    bench.handle->mass.velocity = {};
    const double height = bench.handle->mass.position[2];
    for (int n = 0; n < 1000; ++n) bench.tick();
    EXPECT_NEAR(height - bench.handle->mass.position[2], told > 0.0 ? 0.0 : 0.65, 0.05);
  }
}

/// The device may change the force in any way. The reported work must be exactly the motors' work
/// minus W (z - z_0). Over a closed path the reported work must be complete.
TEST(ProtectedDevice, WhatIsNotToldIsAFunctionOfThePlace) {
  struct Odd final : Device {
    DeviceSpec described = builtin_device("simulated");
    std::mt19937 random{9};
    std::uniform_real_distribution<double> part{-1.0, 1.0};
    Vec3 place = Vec3::Zero();
    Command real;  // force on the hand since the last reading
    double motors = 0.0;
    bool moves = false;
    const DeviceSpec& spec() const override { return described; }
    DeviceReading read(Nanoseconds) noexcept override {
      const Vec3 way =
          moves ? Vec3(0.001 * Vec3(part(random), part(random), part(random))) : Vec3::Zero();
      place += way;
      motors += real.force().dot(way);
      return {.pose = {.position = place}, .held = real};
    }
    /// Scales, rotates and delays the force, unlike any real amplifier.
    Command write(const Command& command) noexcept override {
      const double share = moves ? 0.5 + 0.5 * part(random) : 1.0;
      real = {.elastic = share * command.force()};
      if (moves && part(random) > 0.5) real.elastic += Vec3(part(random), 0, part(random));
      return real;
    }
    void release() noexcept override {}
  };
  constexpr double kWeight = 0.7;
  auto* odd = new Odd;
  ProtectedDevice device(std::unique_ptr<Device>(odd), {.tool_weight = kWeight},
                         std::make_shared<EmergencyStop>());
  Nanoseconds now = std::chrono::seconds(1);
  const auto read = [&] { return device.read(now += from_seconds(kTick)); };
  while (read().withheld != Withheld::nothing) device.write({});
  device.write({});
  odd->moves = true;
  const Vec3 start = odd->place;
  Vec3 before = start;
  double told = 0.0;
  for (int n = 0; n < 5000; ++n) {
    const DeviceReading reading = read();
    ASSERT_EQ(reading.withheld, Withheld::nothing);
    told += reading.held->force().dot(reading.pose.position - before);
    before = reading.pose.position;
    device.write({.elastic = Vec3(odd->part(odd->random), 0, 1)});
  }
  EXPECT_GT(std::abs(odd->motors), 1e-3);
  EXPECT_NEAR(odd->motors - told, kWeight * (before.z() - start.z()), 1e-12);
}

TEST(ProtectedDevice, TheToolIsAPartOfTheDevicesForceAndOfTheHands) {
  const DeviceSpec plain = builtin_device("simulated");
  const DeviceSpec spec = protected_spec(plain, {.tool_weight = 0.5});
  EXPECT_DOUBLE_EQ(spec.max_force, plain.max_force - 0.5);
  EXPECT_DOUBLE_EQ(spec.continuous_force, plain.continuous_force - 0.5);
  EXPECT_DOUBLE_EQ(spec.hand_force, plain.hand_force + 0.5);
  EXPECT_EQ(spec.least_mass, plain.least_mass);
  const auto refusal = [&](const DeviceSpec& device, const ProtectionOptions& options) {
    try {
      protected_spec(device, options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(refusal(plain, {.tool_weight = -1.0}), HasSubstr("above 0"));
  EXPECT_THAT(refusal(plain, {.tool_weight = 100.0}), HasSubstr("lighter"));
  DeviceSpec plane = plain;
  plane.translation_dof = 2;
  EXPECT_THAT(refusal(plane, {.tool_weight = 0.1}), HasSubstr("no force along z"));
  EXPECT_THAT(refusal(plain, {.emergency_button = 33}), HasSubstr("emergency_button of --device"));
  EXPECT_THAT(refusal(plain, {.still = -1.0}), HasSubstr("await_still"));
  EXPECT_THAT(refusal(plain, {.deadman_button = 33}), HasSubstr("deadman_button of --device"));
  EXPECT_THAT(refusal(plain, {.clutch_button = -1}), HasSubstr("clutch_button of --device"));
}

/// The chosen buttons must replace the device's own switch and clutch.
TEST(ProtectedDevice, TheSwitchAndTheClutchAreTheChosenButtons) {
  const auto told = [](const ProtectionOptions& options, std::uint32_t buttons) {
    Bench bench(options);
    bench.handle->deadman = bench.handle->clutch = true;
    bench.handle->buttons = buttons;
    const DeviceReading reading = bench.tick();
    return std::pair(reading.deadman, reading.clutch);
  };
  EXPECT_EQ(told({}, 0), std::pair(true, true));
  EXPECT_EQ(told({.deadman_button = 3}, 0), std::pair(false, true));
  EXPECT_EQ(told({.deadman_button = 3}, 4), std::pair(true, true));
  EXPECT_EQ(told({.clutch_button = 32}, 4), std::pair(true, false));
  EXPECT_EQ(told({.deadman_button = 1, .clutch_button = 32}, 1U << 31U), std::pair(false, true));
  EXPECT_EQ(told({.deadman_button = 0, .clutch_button = 0}, ~0U), std::pair(false, false));
}

TEST(ProtectedDevice, AnEmergencyTakesAllForceOffUntilItIsReset) {
  Bench bench({.tool_weight = 0.5, .emergency_button = 2, .still = 0.25});
  bench.start();
  bench.tick(kPull);
  ASSERT_EQ(bench.up(), 3.5);
  bench.emergency->press();
  // The stop must also work between read and write.
  EXPECT_EQ(bench.device.write(kPull), Command{});
  EXPECT_EQ(bench.handle->on_hand, Command{});
  for (int n = 0; n < 3000; ++n) {
    EXPECT_EQ(bench.tick(kPull).withheld, Withheld::emergency);
    EXPECT_EQ(bench.handle->on_hand, Command{});
  }
  bench.emergency->reset();
  bench.tick(kPull);
  EXPECT_EQ(bench.handle->on_hand, Command{});
  EXPECT_NEAR(bench.start() * kTick, 0.25 + kUp, 0.02);
  bench.handle->buttons = 1;
  EXPECT_EQ(bench.tick(kPull).withheld, Withheld::nothing);
  bench.handle->buttons = 2;
  EXPECT_EQ(bench.tick(kPull).withheld, Withheld::emergency);
  bench.handle->buttons = 0;
  EXPECT_EQ(bench.tick(kPull).withheld, Withheld::emergency);
  EXPECT_EQ(bench.handle->on_hand, Command{});
}

TEST(ProtectedDevice, OutOfTheInkwellItStartsAnew) {
  Bench bench({.tool_weight = 0.5, .still = 0.25});
  bench.start();
  bench.handle->withheld = Withheld::in_inkwell;
  EXPECT_EQ(bench.tick(kPull).withheld, Withheld::in_inkwell);
  EXPECT_EQ(bench.handle->on_hand, Command{});
  bench.handle->withheld = Withheld::nothing;
  EXPECT_NEAR(bench.start() * kTick, 0.25 + kUp, 0.02);
}

/// After a fault or missed ticks the weight must return gradually.
TEST(ProtectedDevice, AfterAFaultTheWeightIsTakenUpAnew) {
  Bench bench({.tool_weight = 0.5, .still = 0.25});
  bench.start();
  bench.handle->ok = false;
  bench.tick();
  EXPECT_EQ(bench.up(), 0.0);
  bench.handle->ok = true;
  EXPECT_NEAR(bench.start() * kTick, kUp, 0.01);
  bench.now += std::chrono::milliseconds(50);
  EXPECT_EQ(bench.tick().withheld, Withheld::starting);
  EXPECT_LE(bench.up(), 0.01);
}

TEST(ProtectedDevice, AtTheEndTheToolIsLetDownSlowly) {
  Bench bench({.tool_weight = 0.5});
  bench.start();
  double before = 0.5;
  int ticks = 0;
  while (!bench.device.lower_tool(bench.now)) {
    bench.tick();
    EXPECT_LE(bench.up(), before);
    EXPECT_GE(bench.up(), before - 0.5 * kTick / kUp * (1.0 + 1e-9));
    before = bench.up();
    ++ticks;
  }
  bench.tick();
  EXPECT_EQ(bench.up(), 0.0);
  EXPECT_NEAR(ticks * kTick, kUp, 0.01);
  EXPECT_TRUE(Bench({}).device.lower_tool({}));
}

/// Returns the energy [J] that the true motion made in addition to the constant force, in ten
/// seconds at a late wall.
double made(const WorkspaceMapping& mapping, double told, double real, std::size_t lag) {
  Mapped mapped(mapping, kSessionMethod, false, lag, true, {.tool_weight = told});
  mapped.handle->mass.tool = real;
  // The count starts with the account, because the account does not include earlier dissipation.
  // Before the start the handle has no delay. Later the handle has the delay that it reports.
  mapped.handle->lag = 0;
  do mapped.tick();
  while (mapped.servo.no_force() == ZeroForceReason::starting);
  mapped.handle->lag = lag;
  mapped.handle->mass.counter = told;
  mapped.handle->mass.delivered = mapped.handle->mass.burned = mapped.handle->mass.most_made = 0.0;
  mapped.run(10.0);
  EXPECT_GT(mapped.handle->mass.largest_force, told + 0.1);
  return mapped.handle->mass.most_made;
}

/// The tool has the declared weight, none, or twice that weight.
TEST(ProtectedDevice, MakesNoEnergyBesideTheConstantForce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> weights(0.05, 1.5);
  for (int n = 0; n < test::rounds(30); ++n) {
    const WorkspaceMapping mapping = any_mapping(random);
    const double told = weights(random);
    EXPECT_LE(made(mapping, told, told * (n % 3), n % 2), 1e-12) << n << " weight " << told;
  }
}

TEST(ProtectedDevice, ATickDoesNotTouchTheHeap) {
  Mapped mapped({}, kSessionMethod, false, 0, true, {.tool_weight = 0.3, .emergency_button = 1});
  mapped.run(1.0);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) {
    mapped.handle->buttons = n == 500 ? 1 : 0;
    if (n == 600) mapped.emergency->reset();
    mapped.servo.tick(mapped.device, mapped.now += from_seconds(kTick));
  }
  EXPECT_EQ(test::allocations() - before, 0u);
}

}  // namespace
}  // namespace feltwire::protected_device_test
