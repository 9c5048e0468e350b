// Tests the Falcon's driver against a substitute of libusb. The substitute has a Falcon of known
// true motion.

#include "client/drivers/novint/falcon.hpp"

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <fstream>

#include "client/device/protected_device.hpp"
#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/devices/falcon_stand_in.hpp"
#include "tests/devices/identified.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/hurry.hpp"

namespace feltwire::falcon_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::PacedSession;

struct Falcon : ::testing::Test {
  Falcon() : library(::dlopen(FELTWIRE_LIBUSB_STAND_IN, RTLD_NOW | RTLD_LOCAL)) {
    using New = stand_in::Falcon*();
    stand_in = reinterpret_cast<New*>(::dlsym(library, "stand_in_new"))();
    stand_in->wanted.resize(7777);
    for (std::size_t i = 0; i < stand_in->wanted.size(); ++i)
      stand_in->wanted[i] = static_cast<std::uint8_t>(i * i + i / 7);
  }
  ~Falcon() override {
    EXPECT_EQ(stand_in->misuses, 0);
    EXPECT_EQ(stand_in->opened, stand_in->closed);
    EXPECT_EQ(stand_in->motor_before_homing, 0);
    ::dlclose(library);
  }
  OpenedDevice open(const std::string& firmware = "", const std::string& name = "") const {
    DeviceRequest request;
    request.name = name;
    request.firmware = firmware;
    request.spec.damping = stand_in->mass.damping;
    request.spec.mass = stand_in->mass.mass;
    return open_falcon(request);
  }
  std::string refusal(const std::string& firmware = "", const std::string& name = "") const {
    try {
      open(firmware, name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }
  std::string file(const std::vector<std::uint8_t>& bytes) const {
    const auto path = folder / "firmware.bin";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
    return path.string();
  }
  static Servo servo_of(const OpenedDevice& opened, std::string_view mode = kUnbounded) {
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    return Servo(opened.device->spec(), parameters, {});
  }
  void feel(Device& device, Servo& servo) {
    session.run(device, servo, [&] { return stand_in->force > 0.5; });
  }
  /// After a fault the force must end at once and return later. The fault must be counted.
  void recovers(const char* name, std::atomic<int>& fault) {
    const OpenedDevice opened = open();
    Servo servo = servo_of(opened);
    feel(*opened.device, servo);
    session.suffer(*opened.device, servo, stand_in->edge, fault);
    EXPECT_EQ(servo.given(), Command{});
    session.run(*opened.device, servo, [&] { return stand_in->edge.ended(); });
    session.expect_let_go("falcon", name, stand_in->edge);
    feel(*opened.device, servo);
  }
  /// Returns the excess [J] of the true motion's energy over the dissipated energy, in four seconds
  /// at a late wall.
  double made(std::string_view mode) {
    const double kRequests = 1e3 * testing::session_seconds(4.0);
    if (!testing::measures()) session.patience = std::chrono::seconds(10);
    OpenedDevice opened = open();
    Servo servo = servo_of(opened, mode);
    const int first = stand_in->requests;
    session.run(*opened.device, servo, [&] { return stand_in->requests >= first + kRequests; });
    statistics = servo.statistics();
    opened.device.reset();  // The device sends no more requests.
    session.tell("falcon", servo, stand_in->mass.largest_force, stand_in->mass.most_made);
    EXPECT_GT(stand_in->mass.largest_force, 0.5);
    return stand_in->mass.most_made;
  }

  testing::TemporaryFolder folder;
  void* library;
  stand_in::Falcon* stand_in;
  PacedSession session;
  ServoStatistics statistics;
};

TEST_F(Falcon, SaysWhatItIs) {
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().name, "falcon");
  EXPECT_EQ(opened.device->spec().max_force, 8.0);
  EXPECT_EQ(opened.device->spec().actuation.late_ticks,
            1);  // A force acts from the next answer on.
  EXPECT_GE(opened.device->longest_tick(), std::chrono::microseconds(1250));
  EXPECT_EQ(stand_in->loads, 0);  // The firmware already ran.
  EXPECT_THAT(opened.notes, Contains(HasSubstr("not calibrated")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("watchdog")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("gravity compensation")));
}

TEST_F(Falcon, WhatIsMissingIsSaid) {
  EXPECT_THAT(refusal("", "second"), HasSubstr("0 to 15"));
  EXPECT_THAT(refusal("", "1"), HasSubstr("only 1"));
  stand_in->busy = true;
  EXPECT_THAT(refusal(), HasSubstr("another program"));
  stand_in->accessible = false;
  EXPECT_THAT(refusal(), HasSubstr("udev"));
  stand_in->plugged = false;
  EXPECT_THAT(refusal(), HasSubstr("plug it in"));
}

TEST_F(Falcon, ItsFirmwareIsLoadedFromTheUsersFile) {
  stand_in->loaded = false;
  EXPECT_THAT(refusal(), HasSubstr("--device falcon:firmware=FILE"));
  EXPECT_EQ(stand_in->loads, 0);
  stand_in->hello_misses = 3;
  stand_in->wrong_echoes = 2;  // Two loads fail.
  const OpenedDevice opened = open(file(stand_in->wanted));
  EXPECT_EQ(stand_in->loads, 3);
  EXPECT_TRUE(stand_in->loaded);
  EXPECT_TRUE(opened.device->prepare().empty());
}

TEST_F(Falcon, AFirmwareThatDoesNotLoadOrRunIsRefused) {
  stand_in->loaded = false;
  stand_in->wrong_echoes = 100;
  EXPECT_THAT(refusal(file(stand_in->wanted)), HasSubstr("is not what was sent"));
  EXPECT_EQ(stand_in->loads, 5);
  stand_in->wrong_echoes = 0;
  EXPECT_THAT(refusal(file({1, 2, 3})), HasSubstr("does not answer; is it the Falcon's?"));
  EXPECT_THAT(refusal(file({})), HasSubstr("empty"));
  EXPECT_THAT(refusal("/proc/nowhere/firmware.bin"), HasSubstr("/proc/nowhere/firmware.bin"));
  stand_in->refuses_load = true;
  EXPECT_THAT(refusal(file(stand_in->wanted)), HasSubstr("takes no firmware"));
}

/// The driver must ask the user to home the device. All motor commands must be zero until then, and
/// again if the homing is lost later. The fixture checks each request.
TEST_F(Falcon, GivesNoForceBeforeItIsHomed) {
  stand_in->homed = 3;
  const OpenedDevice opened = open();
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("all the way out"));
  EXPECT_TRUE(stand_in->homing);
  EXPECT_EQ(stand_in->lights, 2);
  Servo servo = servo_of(opened);
  session.run(*opened.device, servo,
              [&] { return servo.no_force() == ZeroForceReason::not_homed; });
  const int requests = stand_in->requests;
  session.run(*opened.device, servo, [&] { return stand_in->requests > requests + 300; });
  EXPECT_EQ(stand_in->largest_motor, 0);
  EXPECT_EQ(servo.statistics().samples, 0u);  // The position is unknown.
  stand_in->homed = 7;
  EXPECT_TRUE(opened.device->prepare().empty());
  feel(*opened.device, servo);
  EXPECT_FALSE(stand_in->homing);
  EXPECT_EQ(stand_in->lights, 4);
}

TEST_F(Falcon, AxesAreOurs) {
  stand_in->mass.position = {0.01, 0.02, -0.015};
  stand_in->mass.stiffness = stand_in->mass.hand_damping = 0.0;
  const OpenedDevice opened = open();
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  const DeviceReading reading = opened.device->read({});
  ASSERT_TRUE(reading.ok);
  EXPECT_NEAR((reading.pose.position - Vec3(0.01, 0.02, -0.015)).norm(), 0.0, 7e-5);
}

/// A force along an axis must move the free mass in this direction. The magnitude of the force must
/// be in newtons.
TEST_F(Falcon, ForcesAreOurs) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    stand_in->mass = {};
    stand_in->mass.position = {};
    stand_in->mass.stiffness = stand_in->mass.hand_damping = stand_in->mass.friction = 0.0;
    OpenedDevice opened = open();
    Command held;
    for (int n = 0; n < 30; ++n) {
      ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
      ASSERT_TRUE(opened.device->read({}).ok);
      held = opened.device->write({.elastic = 0.8 * Vec3::Unit(static_cast<int>(axis))});
    }
    EXPECT_NEAR(held.force()[static_cast<int>(axis)], 0.8, 0.01);
    EXPECT_NEAR(stand_in->force, held.force().norm(), 0.01);
    opened.device.reset();  // The device sends no more requests.
    EXPECT_GT(stand_in->mass.velocity[axis], 0.1);
    EXPECT_LT(std::abs(stand_in->mass.velocity[(axis + 1) % 3]), 0.01);
  }
}

TEST_F(Falcon, ButtonsAreTold) {
  const OpenedDevice opened = open();
  stand_in->buttons = 5;
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  opened.device->write({});
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  const DeviceReading reading = opened.device->read({});
  EXPECT_EQ(reading.buttons, 5u);
  EXPECT_TRUE(reading.deadman);
  EXPECT_FALSE(reading.clutch);
}

TEST_F(Falcon, IdentifyMeasuresAFreeHandle) {
  const test::Hurry hurry;
  testing::let_free(stand_in->mass);
  OpenedDevice opened = open();
  testing::Identified identified(*opened.device);
  identified.run(*opened.device, [&] { return 1e-3 * stand_in->requests.load(); });
  opened.device.reset();  // The device sends no more requests.
  identified.expect_below(stand_in->mass);
}

/// An unhomed handle must get no force, and a lost homing must end the measurement.
TEST_F(Falcon, IdentifyWaitsForTheZero) {
  const test::Hurry hurry;
  testing::let_free(stand_in->mass);
  stand_in->homed = 3;
  const OpenedDevice opened = open();
  std::string wanted;
  EXPECT_THROW(
      await_prepared(*opened.device, Nanoseconds(0), [&](std::string_view text) { wanted = text; }),
      std::runtime_error);
  EXPECT_THAT(wanted, HasSubstr("all the way in"));
  testing::Identified identified(*opened.device);
  const auto time = [&] { return 1e-3 * stand_in->requests.load(); };
  identified.run(*opened.device, time, [&] { return stand_in->requests > 3000; });
  EXPECT_EQ(stand_in->largest_motor, 0);
  EXPECT_THAT(identified.status.awaits.load(), HasSubstr("not homed"));
  stand_in->homed = 7;
  identified.run(*opened.device, time, [&] { return stand_in->force > 0.01; });
  stand_in->homed = 6;
  // A user has a minute. Here the time runs thirty times as fast.
  identified.run(*opened.device, [&, begin = time()] { return begin + 30.0 * (time() - begin); });
  EXPECT_THAT(std::string(identified.identification.why()), HasSubstr("not homed"));
  stand_in->motor_before_homing = 0;  // This call removes the request that was still in the queue.
}

TEST_F(Falcon, MakesNoEnergy) {
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_EQ(statistics.device.faults, 0u);
}
/// Without a bound the wall must make energy. This shows that the measurement can fail.
TEST_F(Falcon, TheWallAloneWouldMakeEnergy) { EXPECT_GT(made(kUnbounded), 0.005); }

TEST_F(Falcon, MakesNoneWithFaults) {
  stand_in->in_pieces = true;
  stand_in->drops = 2;
  stand_in->garbles = 2;
  stand_in->jumps = 2;
  stand_in->repeats = 2;
  EXPECT_THAT(refusal(), ::testing::AnyOf("none", HasSubstr("answer")));
  stand_in->drops = stand_in->garbles = stand_in->jumps = stand_in->repeats = 0;
  EXPECT_LE(made(kSessionMethod), 1e-12);
}

TEST_F(Falcon, RecoversFromALostAnswer) { recovers("drops", stand_in->drops); }
TEST_F(Falcon, RecoversFromAGarbledAnswer) { recovers("garbles", stand_in->garbles); }
TEST_F(Falcon, RecoversFromAnAnswerWithoutAnEnd) { recovers("wrong_ends", stand_in->wrong_ends); }
TEST_F(Falcon, RecoversFromAnArmThatJumps) { recovers("jumps", stand_in->jumps); }
TEST_F(Falcon, RecoversFromAShortTransfer) { recovers("short_writes", stand_in->short_writes); }
TEST_F(Falcon, RecoversFromALateAnswer) { recovers("late", stand_in->late); }
TEST_F(Falcon, RecoversFromAnAnswerThatComesTwice) { recovers("repeats", stand_in->repeats); }

/// A USB transfer that does not return must block only the driver's own thread. This thread must
/// end the force as soon as the transfer returns.
TEST_F(Falcon, ABlockedTransferNeverHoldsTheServoUp) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  stand_in->blocks = true;
  const std::uint64_t faults = servo.statistics().device.faults;
  session.run(*opened.device, servo, [&] { return servo.statistics().device.faults > faults + 5; });
  EXPECT_EQ(servo.given(), Command{});
  session.stiffness = 0.0;
  stand_in->edge.strike();
  stand_in->blocks = false;
  test::eventually("it is let go", [&] { return stand_in->edge.ended(); });
  testing::expect_in_time("falcon", "a blocked transfer", stand_in->edge, 0.0);
}

TEST_F(Falcon, UnpluggedItIsAFaultForGood) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  stand_in->unplug = true;
  session.run(*opened.device, servo, [&] { return servo.statistics().device.faults > 3; });
  EXPECT_EQ(servo.given(), Command{});
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("does not answer"));
}

TEST_F(Falcon, ReleaseTakesTheForceOffForGood) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  opened.device->release();
  test::eventually("it is let go", [&] { return stand_in->force == 0.0; });
  const int requests = stand_in->requests;
  session.run(*opened.device, servo, [&] { return stand_in->requests > requests + 50; });
  EXPECT_EQ(stand_in->force, 0.0);
}

TEST_F(Falcon, AnotherThreadMayLetItGo) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  session.run_released(*opened.device, servo, [&] { return stand_in->force == 0.0; });
}

/// If the device is closed during a force, the driver's own thread must end the force.
TEST_F(Falcon, ClosedItHoldsNothing) {
  {
    const OpenedDevice opened = open();
    Servo servo = servo_of(opened);
    feel(*opened.device, servo);
  }
  EXPECT_EQ(stand_in->force, 0.0);
}

TEST_F(Falcon, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 500; ++n)
    if (opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25)))
      servo.tick(*opened.device, monotonic_now());
  EXPECT_EQ(test::allocations() - before, 0u);
}

}  // namespace
}  // namespace feltwire::falcon_test
