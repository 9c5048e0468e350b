// Tests the driver of OpenHaptics against a substitute of the maker's library with its callbacks.

#include "client/drivers/open_haptics/open_haptics.hpp"

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "client/run/device_check.hpp"
#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/devices/hd_stand_in.hpp"
#include "tests/devices/identified.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::open_haptics_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

struct OpenHaptics : ::testing::Test {
  OpenHaptics() : library(::dlopen(FELTWIRE_HD_STAND_IN, RTLD_NOW | RTLD_LOCAL)) {
    ::setenv("OH_SDK_BASE", FELTWIRE_OH_SDK, 1);
    using New = stand_in::Hd*();
    stand_in = reinterpret_cast<New*>(::dlsym(library, "stand_in_new"))();
  }
  ~OpenHaptics() override {
    ::unsetenv("OH_SDK_BASE");
    ::dlclose(library);
  }
  static OpenedDevice open(const std::string& name = "", const SpecRequest& spec = {}) {
    DeviceRequest request;
    request.name = name;
    request.spec = spec;
    return open_haptics(request);
  }
  static std::string refusal(const std::string& name = "") {
    try {
      open(name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }

  template <class Until>
  void felt(Device& device, Servo& servo, Until until) {
    testing::PacedSession().run(device, servo, until);
  }

  /// Returns true after more than `faults` faults and without a held force. If a zero is too late
  /// for its tick, the driver sends it in the next tick.
  static bool let_go(const Servo& servo, std::uint64_t faults) {
    return servo.statistics().device.faults > faults && servo.held() == Command{};
  }

  /// Returns the excess [J] of the true motion's energy over the dissipated energy, in four seconds
  /// at a late wall.
  double made(std::string_view mode) {
    const double kFrames = 1e3 * testing::session_seconds(4.0);
    OpenedDevice opened = open(
        "", {.name_or_file = {}, .damping = stand_in->mass.damping, .mass = stand_in->mass.mass});
    DeviceSpec spec = opened.device->spec();
    spec.position_resolution = stand_in->mass.quantum;
    spec.least_friction = stand_in->mass.friction;
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    Servo servo(spec, parameters, {});
    testing::PacedSession session;
    session.run(*opened.device, servo, [&] { return stand_in->frames >= kFrames; });
    statistics = servo.statistics();
    opened.device.reset();  // The scheduler has stopped.
    session.tell("openhaptics", servo, stand_in->mass.largest_force, stand_in->mass.most_made);
    EXPECT_EQ(stand_in->misuses, 0);
    return stand_in->mass.most_made;
  }

  void* library;
  stand_in::Hd* stand_in;
  ServoStatistics statistics;
};

TEST_F(OpenHaptics, IsOpenedByDefaultOrByName) {
  {
    const OpenedDevice opened = open();
    EXPECT_EQ(opened.device->spec().name, "touch");
    EXPECT_EQ(opened.device->spec().max_force, 3.3);
    EXPECT_EQ(opened.device->longest_tick(), std::chrono::microseconds(1250));
    EXPECT_THAT(opened.notes, Contains(HasSubstr("damping 0.05 N s/m is an assumption")));
    EXPECT_THAT(opened.notes, Contains(HasSubstr("no longest tick")));
  }
  EXPECT_EQ(stand_in->closed, 1);
  stand_in->known = "Default PHANToM";
  open();
  stand_in->known = "left";
  open("left");
  EXPECT_EQ(stand_in->opened, 3);
  stand_in->model = "Premium 1.5";
  EXPECT_EQ(open("left").device->spec().name, "phantom_premium_1.5");
  EXPECT_EQ(open("left").device->spec().rotation_actuated, 0);
  EXPECT_EQ(stand_in->misuses, 0);
}

TEST_F(OpenHaptics, TheLagOfItsConnectionIsAssumed) {
  EXPECT_EQ(open().device->spec().actuation.lag, 0.5e-3);
  EXPECT_THAT(open().notes, Contains(HasSubstr("s is an assumption for USB; ")));
  stand_in->model = "Premium 1.5";
  EXPECT_EQ(open().device->spec().actuation.lag, 0.3e-3);
  EXPECT_THAT(open().notes, Contains(HasSubstr("s is an assumption for PCI or a parallel port; ")));
  stand_in->model = "Desktop";
  EXPECT_EQ(open().device->spec().actuation.lag, 0.5e-3);
}

TEST_F(OpenHaptics, WhatIsMissingIsSaid) {
  stand_in->plugged = false;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("default one"), HasSubstr("HD_DEVICE_FAULT")));
  EXPECT_THAT(refusal("left"), AllOf(HasSubstr("'left'"), HasSubstr("Touch Setup")));
  stand_in->plugged = true;
  stand_in->calibration = 0x5002;
  EXPECT_THAT(refusal(), HasSubstr("inkwell"));
  EXPECT_EQ(stand_in->closed, 1);
  stand_in->calibration = 0x5001;  // The user must calibrate in the inkwell.
  EXPECT_THAT(refusal(), HasSubstr("inkwell"));
  stand_in->style = 2;
  EXPECT_EQ(refusal(), "none");
  EXPECT_EQ(stand_in->updates, 1);
  ::setenv("OH_SDK_BASE", "/proc/nowhere", 1);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("libHD.so"), HasSubstr("OH_SDK_BASE")));
}

TEST_F(OpenHaptics, AxesAndUnitsAreOurs) {
  stand_in->mass.position = {0.01, 0.02, 0.03};
  stand_in->mass.stiffness = stand_in->mass.hand_damping = 0.0;
  const OpenedDevice opened = open();
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  const DeviceReading reading = opened.device->read({});
  EXPECT_NEAR((reading.pose.position - Vec3(0.01, 0.02, 0.03)).norm(), 0.0, 3e-5);
  EXPECT_NEAR(reading.pose.orientation.w(), 1.0, 1e-12);
}

/// The driver must send torque in thousandths, along the maker's axes.
TEST_F(OpenHaptics, APremiumWithMotorsAtTheWristIsGivenTorque) {
  stand_in->model = "PHANTOM Premium 1.5 6DOF";
  stand_in->output_dof = 6;
  OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().name, "phantom_premium_1.5_6dof");
  EXPECT_EQ(opened.device->spec().rotation_actuated, 3);
  const Command turn{.elastic = Vec3(0.1, 0.2, 0.3), .torque = Vec3(0.01, 0.02, 0.03)};
  constexpr int kFrames = 1700;  // beyond the driver's start without force (1 s) and the ramp
  while (stand_in->frames < kFrames) {
    opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25));
    opened.device->read({});
    opened.device->write(turn);
  }
  EXPECT_GT(stand_in->largest_torque, 0.9 * turn.torque.norm());
  EXPECT_LT(stand_in->largest_torque, 1.1 * turn.torque.norm());
  EXPECT_GT(stand_in->about_near, 0.9 * 0.01);
  EXPECT_LT(stand_in->about_near, 1.1 * 0.01);
  opened.device.reset();
  EXPECT_EQ(stand_in->torque, stand_in::Three{});
  EXPECT_EQ(stand_in->misuses, 0);
}

TEST_F(OpenHaptics, ButtonsAreTheEnablingSwitchAndTheClutch) {
  const OpenedDevice opened = open();
  const auto pressed = [&](int buttons) {
    stand_in->buttons = buttons;
    const int before = stand_in->frames;
    DeviceReading reading;
    while (stand_in->frames < before + 2) {
      opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25));
      reading = opened.device->read({});
    }
    return std::pair(reading.deadman, reading.clutch);
  };
  EXPECT_EQ(pressed(0), std::pair(false, false));
  EXPECT_EQ(pressed(1), std::pair(true, false));
  EXPECT_EQ(pressed(2), std::pair(false, true));
}

/// identify must wait for the end of the maker's ramp, which is no fault.
TEST_F(OpenHaptics, IdentifyMeasuresAFreeHandle) {
  testing::let_free(stand_in->mass);
  stand_in->virtual_time = true;
  OpenedDevice opened = open();
  testing::Identified identified(*opened.device);
  identified.run(*opened.device, [&] { return stand_in->told_at.load(); });
  opened.device.reset();  // The scheduler has stopped.
  identified.expect_below(stand_in->mass);
  EXPECT_EQ(stand_in->asked_ramping, 0.0);
}

/// identify must not move a stylus in the inkwell. A return of the stylus must end the measurement.
TEST_F(OpenHaptics, IdentifyWaitsForTheStylus) {
  testing::let_free(stand_in->mass);
  stand_in->inkwell.store(true);
  OpenedDevice opened = open();
  testing::Identified identified(*opened.device);
  const auto now = [] { return seconds(monotonic_now()); };
  identified.run(*opened.device, now, [&] { return stand_in->frames > 1500; });
  EXPECT_EQ(stand_in->asked_in_inkwell, 0.0);
  EXPECT_THAT(identified.status.awaits.load(), HasSubstr("take it out"));
  stand_in->inkwell.store(false);
  identified.run(*opened.device, now, [&] { return stand_in->force > 0.01; });
  stand_in->inkwell.store(true);
  // A user has a minute. Here the time runs thirty times as fast.
  identified.run(*opened.device, [&, begin = now()] { return begin + 30.0 * (now() - begin); });
  EXPECT_THAT(std::string(identified.identification.why()), HasSubstr("in its inkwell"));
}

/// The ramp must not count as a fault.
TEST_F(OpenHaptics, ItsRateIsMeasuredFromTheStart) {
  const OpenedDevice opened = open();
  const DeviceTicks ticks = watch_ticks(*opened.device, 0.5, 1000.0);
  EXPECT_GT(ticks.ticks, 50u);
  EXPECT_EQ(ticks.faults, 0u);
}

/// The wall's force acted on the mass, the force ramped at the start, and the port made no energy.
TEST_F(OpenHaptics, MakesNoEnergy) {
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_GT(stand_in->mass.largest_force, 0.5);
  EXPECT_EQ(stand_in->asked_ramping, 0.0);
  EXPECT_GT(statistics.samples, 2000u);
}

/// Without a bound the wall must make energy. This shows that the measurement can fail.
TEST_F(OpenHaptics, TheWallAloneWouldMakeEnergy) { EXPECT_GT(made(kUnbounded), 0.005); }

/// The stylus is in the inkwell at the start, and later during contact. The driver must give no
/// force and report no fault.
TEST_F(OpenHaptics, InItsInkwellItIsGivenNothing) {
  stand_in->inkwell.store(true);
  OpenedDevice opened = open();
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("inkwell"));
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  // The client must still send the pose. The next frame may have begun, so the test looks
  // repeatedly.
  felt(*opened.device, servo, [&] {
    return servo.no_force() == ZeroForceReason::in_inkwell &&
           servo.sample().pose.position.x() == stand_in->told_near;
  });
  stand_in->inkwell.store(false);
  test::eventually("it is out", [&] { return opened.device->prepare().empty(); });
  felt(*opened.device, servo, [&] { return stand_in->force > 0.5; });
  const std::uint64_t faults = servo.statistics().device.faults;
  testing::PacedSession session;
  session.strike(stand_in->edge);
  stand_in->inkwell.store(true);
  session.run(*opened.device, servo,
              [&] { return servo.no_force() == ZeroForceReason::in_inkwell; });
  session.run(*opened.device, servo, [&] { return stand_in->edge.ended(); });
  session.expect_let_go("openhaptics", "the inkwell", stand_in->edge);
  stand_in->asked_in_inkwell = 0.0;  // The frame of the change had already begun.
  const int frames = stand_in->frames;
  felt(*opened.device, servo, [&] { return stand_in->frames > frames + 200; });
  EXPECT_EQ(stand_in->asked_in_inkwell, 0.0);
  EXPECT_EQ(stand_in->force, 0.0);
  EXPECT_EQ(servo.statistics().device.faults, faults);
}

/// Too much force switches the amplifiers off. They ramp up again later. The driver must request no
/// force meanwhile, and the servo must report the reason.
TEST_F(OpenHaptics, AfterAnErrorNothingIsAskedForWhileItRamps) {
  OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  felt(*opened.device, servo, [&] { return stand_in->force > 1.0; });
  testing::PacedSession session;
  session.strike(stand_in->edge);
  stand_in->raises.store(0x201);
  const std::uint64_t faults = servo.statistics().device.faults;
  session.run(*opened.device, servo, [&] { return let_go(servo, faults); });
  session.run(*opened.device, servo, [&] { return stand_in->edge.ended(); });
  session.expect_let_go("openhaptics", "an error", stand_in->edge);
  const int frames = stand_in->frames;
  felt(*opened.device, servo, [&] { return servo.no_force() == ZeroForceReason::starting; });
  felt(*opened.device, servo, [&] { return stand_in->force > 1.0; });  // The force must return.
  EXPECT_GE(stand_in->frames, frames + 900);
  // The frame of the error was in progress.
  EXPECT_LE(stand_in->asked_ramping, 3.3 + 1e-9);
}

/// A late scheduler (dropped frames) and an unfinished frame must each make one fault.
TEST_F(OpenHaptics, EveryErrorOfTheDeviceIsAFault) {
  OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  for (const unsigned code : {0x200U, 0x203U, 0x304U, 0x402U}) {
    const std::uint64_t faults = servo.statistics().device.faults;
    stand_in->raises.store(code);
    felt(*opened.device, servo, [&] { return let_go(servo, faults); });
  }
}

/// The fault must last as long as the device is unplugged.
TEST_F(OpenHaptics, UnpluggedItIsAFault) {
  OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  felt(*opened.device, servo, [&] { return stand_in->force > 0.5; });
  const std::uint64_t faults = servo.statistics().device.faults;
  testing::PacedSession session;
  session.strike(stand_in->edge);
  stand_in->fails.store(0x302);
  session.run(*opened.device, servo, [&] { return stand_in->edge.ended(); });
  session.expect_let_go("openhaptics", "unplugged", stand_in->edge);
  session.run(*opened.device, servo,
              [&] { return servo.statistics().device.faults > faults + 100; });
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
}

/// A call of the maker's library does not return. No tick arrives, and the servo must hold no
/// force.
TEST_F(OpenHaptics, AFrameThatDoesNotEndIsAFault) {
  OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  stand_in->blocks.store(true);
  felt(*opened.device, servo, [&] { return servo.statistics().device.faults > 3; });
  EXPECT_EQ(servo.held(), Command{});
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
  stand_in->blocks.store(false);
}

/// A library lacks a function that the driver needs. Another library lacks a dependency.
TEST_F(OpenHaptics, ALibraryThatCannotBeUsedIsRefused) {
  const testing::TemporaryFolder sdk;
  ::setenv("OH_SDK_BASE", (sdk / "").c_str(), 1);
  std::filesystem::create_directory(sdk / "lib");
  std::filesystem::copy_file(FELTWIRE_EMPTY_LIBRARY, sdk / "lib/libHD.so");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("openhaptics: "), HasSubstr("no function hdInitDevice"),
                               HasSubstr("install OpenHaptics 3")));
  EXPECT_THROW(open_haptics_library(), std::runtime_error);
  std::filesystem::remove(sdk / "lib/libHD.so");
  std::filesystem::copy_file(FELTWIRE_NEEDY_LIBRARY, sdk / "lib/libHD.so");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("libPhantomIOLib42.so: cannot open"),
                               HasSubstr("comes with the driver")));
}

TEST_F(OpenHaptics, ReleaseTakesTheForceOffForGood) {
  OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  felt(*opened.device, servo, [&] { return stand_in->force > 0.5; });
  stand_in->edge.strike();
  opened.device->release();
  test::eventually("it is let go", [&] { return stand_in->force == 0.0; });
  testing::expect_in_time("openhaptics", "release", stand_in->edge, 0.0);
  const int frames = stand_in->frames;
  test::eventually("some more frames", [&] { return stand_in->frames > frames + 20; });
  EXPECT_EQ(stand_in->force, 0.0);
}

TEST_F(OpenHaptics, AnotherThreadMayLetItGo) {
  OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  felt(*opened.device, servo, [&] { return stand_in->force > 0.5; });
  testing::PacedSession().run_released(*opened.device, servo,
                                       [&] { return stand_in->force == 0.0; });
}

/// If the servo stops answering, the driver must repeat the force for 25 frames at most.
TEST_F(OpenHaptics, AServoThatStandsStillHoldsNothing) {
  OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  felt(*opened.device, servo, [&] { return stand_in->force > 0.5; });
  stand_in->edge.strike();
  test::eventually("it is let go", [&] { return stand_in->force == 0.0; });
  testing::expect_in_time("openhaptics", "a servo that stops", stand_in->edge, 0.0);
}

TEST_F(OpenHaptics, ASchedulerThatStopsIsAFault) {
  OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  stand_in->stuck.store(true);
  felt(*opened.device, servo, [&] { return servo.statistics().device.faults > 0; });
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
}

/// Neither the servo's thread nor the scheduler's thread may allocate.
TEST_F(OpenHaptics, ATickDoesNotTouchTheHeap) {
  OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  const auto tick = [&](int frames) {
    while (stand_in->frames < frames)
      if (opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25)))
        servo.tick(*opened.device, monotonic_now());
  };
  tick(50);
  const std::size_t here = test::allocations(), there = test::allocations_of_others();
  tick(500);
  EXPECT_EQ(test::allocations() - here, 0u);
  EXPECT_EQ(test::allocations_of_others() - there, 0u);
}

}  // namespace
}  // namespace feltwire::open_haptics_test
