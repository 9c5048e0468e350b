// Tests Force Dimension's driver with faults of its library.

#include <gmock/gmock.h>

#include <filesystem>

#include "client/servo/servo_thread.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/devices/force_dimension_bench.hpp"
#include "tests/devices/identified.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::force_dimension_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::WallSession;

/// The account must not include force above the limit of the motors.
TEST_F(ForceDimension, ASaturatedMotorHoldsLess) {
  const OpenedDevice opened = open();
  stand_in->saturates_at = 2.0;
  const Command held =
      opened.device->write({.elastic = Vec3(0, 3, 0), .frictional = Vec3(4, 0, 0)});
  EXPECT_NEAR(held.force().norm(), 2.0, 1e-12);
  EXPECT_NEAR((held.elastic - 0.4 * Vec3(0, 3, 0)).norm(), 0.0, 1e-12);
  stand_in->tells_force = false;
  EXPECT_EQ(opened.device->write(pull(0, 3, 0)), Command{});
  EXPECT_FALSE(opened.device->read({}).ok);  // The fault lasts until the driver has sent a zero.
  opened.device->write({});
  EXPECT_TRUE(opened.device->read({}).ok);
}

TEST_F(ForceDimension, ForcesThatAreSwitchedOffAreNotHeld) {
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), pull(0, 0, 1));
  stand_in->off_from = 0;
  stand_in->off_until = 2;
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), Command{});
  opened.device->read({});
  opened.device->read({});
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), pull(0, 0, 1));
}

/// After a pause of the program the watchdog switches the force off. The driver must switch the
/// force on again. If a person switched the force off, the force must stay off, and the driver must
/// report the switch.
TEST_F(ForceDimension, WhatSwitchedTheForceOffIsTold) {
  const OpenedDevice opened = open();
  EXPECT_TRUE(opened.device->prepare().empty());
  for (int n = 0; n < 20; ++n) opened.device->read({});
  ASSERT_TRUE(stand_in->watched_off);
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), Command{});
  EXPECT_FALSE(stand_in->force_before_on);
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), pull(0, 0, 1));
  stand_in->off_from = 0;
  stand_in->off_until = 1000;
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), Command{});
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("force button"));
  stand_in->off_cause = 2;
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("too fast"));
  stand_in->plugged = false;
  EXPECT_THAT(std::string(opened.device->prepare()), HasSubstr("cable"));
}

/// A change of the gravity compensation does work. The account must therefore exclude this
/// movement.
TEST_F(ForceDimension, AGravityCompensationThatChangesIsAFault) {
  const OpenedDevice opened = open();
  opened.device->write({});
  ASSERT_TRUE(opened.device->read({}).ok);
  stand_in->gravity_on = false;
  opened.device->write(pull(0, 0, 1));
  EXPECT_FALSE(opened.device->read({}).ok);
  opened.device->write({});
  EXPECT_TRUE(opened.device->read({}).ok);
}

TEST_F(ForceDimension, UnpluggedItIsAFault) {
  const OpenedDevice opened = open();
  opened.device->write(pull(0, 0, 1));
  stand_in->plugged = false;
  EXPECT_FALSE(opened.device->read({}).ok);
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), Command{});
}

TEST_F(ForceDimension, ALibraryWithoutAFunctionIsRefused) {
  const testing::TemporaryFolder sdk;
  const auto folder =
      sdk / "lib/release" / std::filesystem::path(FELTWIRE_DRD_STAND_IN).parent_path().filename();
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(FELTWIRE_EMPTY_LIBRARY, folder / "libdrd.so.3");
  ::setenv("FDSDK", (sdk / "").c_str(), 1);
  const auto fits = AllOf(HasSubstr("forcedimension: "), HasSubstr("no function dhdGetSDKVersion"),
                          HasSubstr("install the Force Dimension SDK"));
  EXPECT_THAT(refusal(), fits);
  try {
    force_dimension_library();
    FAIL() << "the doctor says that it is fine";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), fits);
  }
}

/// A reading within the time guard is not new. The driver must still reset the firmware's watchdog.
TEST_F(ForceDimension, AnOldReadingIsSeenAsSuch) {
  const OpenedDevice opened = open();
  opened.device->read({});
  opened.device->write({});
  stand_in->stale_every = 1;
  const int zeros = stand_in->zeros;
  EXPECT_FALSE(opened.device->read({}).fresh);
  EXPECT_EQ(stand_in->zeros, zeros + 1);
}

TEST_F(ForceDimension, ReleaseTakesTheForceOffForGood) {
  const OpenedDevice opened = open();
  opened.device->write(pull(0, 0, 1));
  ASSERT_TRUE(stand_in->pulls);
  opened.device->release();
  test::eventually("it is let go", [&] { return !stand_in->pulls.load(); });
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), Command{});
  EXPECT_FALSE(stand_in->pulls);
}

/// identify must wait for the end of an initial fault for some time, and then give up.
TEST_F(ForceDimension, IdentifyGivesUpOnAFaultThatStays) {
  const OpenedDevice opened = open();
  stand_in->fails_from = 0;
  stand_in->fails_until = 1000000;
  testing::Identified identified(*opened.device);
  const auto time = [&] { return static_cast<double>(stand_in->readings) * stand_in->period; };
  identified.run(*opened.device, time, [&] { return stand_in->readings >= 4900; });
  EXPECT_EQ(identified.identification.state(), Identification::State::measuring);
  identified.run(*opened.device, time);
  EXPECT_LT(stand_in->readings, 11000);
  EXPECT_THAT(std::string(identified.identification.why()), HasSubstr("cable"));
}

TEST_F(ForceDimension, MakesNoneWithEveryFaultAtOnce) {
  stand_in->stale_every = 5;
  stand_in->saturates_at = 1.0;
  stand_in->fails_from = 3000;
  stand_in->fails_until = 3050;
  stand_in->off_from = 6000;
  stand_in->off_until = 6700;
  EXPECT_LE(made(), 1e-12);
  EXPECT_GE(statistics.device.faults, 50u);
  EXPECT_GT(statistics.device.stale_readings, 1900u);
}

/// No zero reaches the device any more. The firmware's watchdog must end the force.
TEST_F(ForceDimension, CallsThatFailLetTheForceGo) {
  const OpenedDevice opened = open();
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = kUnbounded;
  Servo servo(opened.device->spec(), parameters, {});
  WallSession session{.period = stand_in->period};
  while (!stand_in->pulls) session.tick(*opened.device, servo);
  stand_in->edge.strike();
  stand_in->fails_from = stand_in->readings + 1;
  stand_in->fails_until = stand_in->readings + 1000;
  session.run(*opened.device, servo, 0.5);
  testing::expect_in_time("forcedimension", "calls that fail", stand_in->edge, 0.0);
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
}

/// A USB transfer does not return.
TEST_F(ForceDimension, ABlockedCallLetsTheForceGo) {
  testing::ScenePeer peer;
  SessionParameters parameters;
  parameters.mode = kUnbounded;
  auto task = std::make_shared<ServoTask>(
      open().device, std::make_shared<Transport>(peer.session(), SessionParameters{}, true),
      parameters, ServoOptions{});
  task->priority = ServoTask::kNoRealTime;
  task->let_go_after = parameters.hold_time;  // A busy machine must not trigger the release.
  ServoThread thread(task);
  while (!stand_in->pulls) {
    const auto received = peer.receive();
    if (received.kind == DatagramKind::samples)
      peer.send(testing::ScenePeer::reply_to(received.batch.samples[0], pull(0, 0, 3)));
  }
  stand_in->edge.strike();
  stand_in->blocks.store(true);
  test::eventually("it is let go", [&] { return stand_in->blocked && stand_in->edge.ended(); });
  testing::expect_in_time_by_clock("forcedimension", "a blocked call", stand_in->edge);
  stand_in->blocks.store(false);
  EXPECT_TRUE(thread.end());
  EXPECT_TRUE(task->result.stood_still);
}

}  // namespace
}  // namespace feltwire::force_dimension_test
