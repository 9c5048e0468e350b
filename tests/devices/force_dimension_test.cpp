// The driver of Force Dimension's devices, against a library that answers as theirs does.

#include "client/devices/force_dimension.hpp"

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <numbers>

#include "client/servo/servo_thread.hpp"
#include "tests/client/peer.hpp"
#include "tests/devices/drd_stand_in.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::force_dimension_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::WallSession;

Command pull(double x, double y, double z) { return {.elastic = Vec3(x, y, z)}; }

struct ForceDimension : ::testing::Test {
  ForceDimension() : library(::dlopen(FELTWIRE_DRD_STAND_IN, RTLD_NOW | RTLD_LOCAL)) {
    ::setenv("FDSDK", FELTWIRE_FDSDK, 1);
    using New = stand_in::Drd*();
    stand_in = reinterpret_cast<New*>(::dlsym(library, "stand_in_new"))();
  }
  ~ForceDimension() override {
    ::unsetenv("FDSDK");
    ::dlclose(library);
  }
  static OpenedDevice open(const std::string& name = "") {
    DeviceRequest request;
    request.name = name;
    return open_force_dimension(request);
  }
  /// One whose physics are known: the stand-in's.
  OpenedDevice known() const {
    DeviceRequest request;
    request.spec.damping = stand_in->mass.damping;
    request.spec.mass = stand_in->mass.mass;
    OpenedDevice opened = open_force_dimension(request);
    return opened;
  }
  static std::string refusal(const std::string& name = "") {
    try {
      open(name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }
  /// [J] that the true motion made more than the device burned, in a minute at a late wall.
  double made(std::string_view mode = kSessionMethod, double twist = 0.0) {
    const OpenedDevice opened = known();
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    DeviceSpec spec = opened.device->spec();
    spec.position_resolution = stand_in->mass.quantum;
    spec.least_friction = stand_in->mass.friction;
    Servo servo(spec, parameters, {});
    WallSession session{.twist = twist, .period = stand_in->period};
    session.run(*opened.device, servo, 60.0);
    statistics = servo.statistics();
    return twist > 0.0 ? stand_in->most_made : stand_in->mass.most_made;
  }

  void* library;
  stand_in::Drd* stand_in;
  ServoStatistics statistics;
};

TEST_F(ForceDimension, IsMadeReadyWithoutAKick) {
  {
    const OpenedDevice opened = open();
    EXPECT_EQ(opened.device->spec().name, "omega.7");
    EXPECT_EQ(opened.device->spec().rotation_sensed, 3);
    EXPECT_EQ(opened.device->longest_tick(), Nanoseconds(0));
    EXPECT_TRUE(stand_in->force_on && stand_in->gravity_on);
    EXPECT_FALSE(stand_in->brakes_on || stand_in->force_before_on);
    EXPECT_EQ(stand_in->max_force, 12.0);
    EXPECT_EQ(stand_in->watchdog, 80);  // 10 ms
    EXPECT_THAT(opened.notes, Contains(HasSubstr("damping 0.05 N s/m is an assumption")));
    EXPECT_THAT(opened.notes, Contains(HasSubstr("gravity compensation is on")));
    EXPECT_THAT(opened.notes, Not(Contains(HasSubstr("watchdog"))));
  }
  EXPECT_EQ(stand_in->opened, 1);
  EXPECT_EQ(stand_in->stopped, 1);
  EXPECT_EQ(stand_in->closed, 1);
}

TEST_F(ForceDimension, AWristWithMotorsIsGivenTorque) {
  stand_in->system = "sigma.7";
  stand_in->active_wrist = true;
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().rotation_actuated, 3);
  EXPECT_EQ(stand_in->max_torque, 0.2);
  const Command turn{.elastic = Vec3(0, 3, 0), .torque = Vec3(0, 0, 0.1)};
  EXPECT_EQ(opened.device->write(turn), turn);
  stand_in->turns_at_most = 0.05;
  const Command held = opened.device->write(turn);
  EXPECT_NEAR((held.torque - Vec3(0, 0, 0.05)).norm(), 0.0, 1e-12);
  EXPECT_EQ(held.force(), turn.force());
  EXPECT_FALSE(stand_in->grips);
  opened.device->release();
  test::eventually("it is let go", [&] { return !stand_in->pulls.load(); });
  // Of another model nothing more is known than that it has these motors.
  stand_in->system = "lambda.9";
  const OpenedDevice other = open();
  EXPECT_EQ(other.device->spec().rotation_actuated, 3);
  EXPECT_EQ(other.device->spec().least_inertia, 0.0);
  EXPECT_THAT(other.notes,
              Contains(HasSubstr("rotational_damping 0.0005 N m s/rad is an assumption")));
  stand_in->active_wrist = false;
  EXPECT_EQ(open().device->spec().rotation_actuated, 0);
}

TEST_F(ForceDimension, TheGripperIsTheLeverOfARobots) {
  EXPECT_FALSE(open().device->read({}).gripper);
  stand_in->gap = 0.012;
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->read({}).gripper, 0.012);
  stand_in->fails_from = 0;
  stand_in->fails_until = 100;
  EXPECT_FALSE(opened.device->read({}).gripper);
}

TEST_F(ForceDimension, OtherModelsPromiseLess) {
  stand_in->system = "delta.3";
  stand_in->wrist = false;
  const OpenedDevice delta = open();
  EXPECT_EQ(delta.device->spec().max_force, 20.0);
  EXPECT_EQ(delta.device->spec().rotation_sensed, 0);
  EXPECT_EQ(delta.device->spec().least_mass, 0.0);
  stand_in->system = "pantograph.9";
  EXPECT_EQ(open().device->spec().max_force, 5.0);
}

TEST_F(ForceDimension, WhatIsMissingIsSaid) {
  stand_in->plugged = false;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("no device found (error 5)"), HasSubstr("udev")));
  stand_in->plugged = true;
  EXPECT_THAT(refusal("first"), HasSubstr("0 to 15"));
  stand_in->initialized = false;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("not calibrated"), HasSubstr("HapticInit")));
  EXPECT_EQ(stand_in->closed, 1);
  EXPECT_FALSE(stand_in->force_on);
  stand_in->initialized = true;
  stand_in->major = 2;
  EXPECT_THAT(refusal(), HasSubstr("version 2.17"));
  stand_in->major = 3;
  stand_in->watchdog_works = false;
  EXPECT_THAT(open().notes, Contains(HasSubstr("watchdog could not be set")));
  stand_in->gravity_works = false;
  EXPECT_THAT(open().notes, Contains(HasSubstr("gravity compensation is off")));
  ::setenv("FDSDK", "/nowhere", 1);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("libdrd.so"), HasSubstr("set FDSDK")));
}

TEST_F(ForceDimension, PositionAndFrameAreTheDevices) {
  const OpenedDevice opened = open();
  stand_in->mass.position = {0.01, 0.02, 0.03};
  stand_in->period = 1e-9;
  const DeviceReading reading = opened.device->read({});
  EXPECT_TRUE(reading.ok && reading.fresh);
  EXPECT_NEAR((reading.pose.position - Vec3(0.01, 0.02, 0.03)).norm(), 0.0, 3e-5);
  EXPECT_NEAR((reading.pose.orientation * Vec3::UnitX() - Vec3::UnitY()).norm(), 0.0, 1e-12);
}

TEST_F(ForceDimension, ButtonsAreTheClutchAndTheEnablingSwitch) {
  const OpenedDevice opened = open();
  EXPECT_FALSE(opened.device->read({}).clutch || opened.device->read({}).deadman);
  stand_in->buttons = 1;
  EXPECT_TRUE(opened.device->read({}).clutch);
  EXPECT_FALSE(opened.device->read({}).deadman);
  stand_in->buttons = 2;
  EXPECT_FALSE(opened.device->read({}).clutch);
  EXPECT_TRUE(opened.device->read({}).deadman);
}

/// What the motors cannot give is not accounted as given.
TEST_F(ForceDimension, ASaturatedMotorHoldsLess) {
  const OpenedDevice opened = open();
  stand_in->saturates_at = 2.0;
  const Command held =
      opened.device->write({.elastic = Vec3(0, 3, 0), .frictional = Vec3(4, 0, 0)});
  EXPECT_NEAR(held.force().norm(), 2.0, 1e-12);
  EXPECT_NEAR((held.elastic - 0.4 * Vec3(0, 3, 0)).norm(), 0.0, 1e-12);
  stand_in->tells_force = false;
  EXPECT_EQ(opened.device->write(pull(0, 3, 0)), Command{});
  EXPECT_FALSE(opened.device->read({}).ok);  // until a zero has gone through
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

/// A reading in time guard tells nothing new; meanwhile the firmware's watchdog is kept quiet.
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

TEST_F(ForceDimension, MakesNoEnergy) {
  EXPECT_GT(made(kUnbounded), 0.01);  // what this is measured with can tell
  stand_in->mass = {};
  EXPECT_LE(made(), 1e-12);
  EXPECT_GT(stand_in->mass.largest_force, 0.5);
  EXPECT_EQ(statistics.device_faults, 0u);
  EXPECT_NEAR(static_cast<double>(statistics.samples), 60e3, 1.0);  // none was missed
}

/// A late stop of the wrist beside the late wall, one port.
TEST_F(ForceDimension, MakesNoEnergyByTorqueEither) {
  stand_in->system = "sigma.7";
  stand_in->active_wrist = true;
  constexpr double kTwist = 5.0;  // [N m/rad]
  EXPECT_GT(made(kUnbounded, kTwist), 0.01);
  EXPECT_GT(stand_in->wrist_mass.most_made, 0.001);
  for (const double turns_at_most : {1e9, 0.02}) {
    stand_in->mass = {};
    stand_in->wrist_mass = stand_in::Drd::inertia();
    stand_in->most_made = 0.0;
    stand_in->turns_at_most = turns_at_most;
    EXPECT_LE(made(kSessionMethod, kTwist), 1e-12);
    EXPECT_GT(stand_in->wrist_mass.largest_force, 0.01);  // [N m]
  }
}

TEST_F(ForceDimension, MakesNoneWithEveryFaultAtOnce) {
  stand_in->stale_every = 5;
  stand_in->saturates_at = 1.0;
  stand_in->fails_from = 3000;
  stand_in->fails_until = 3050;
  stand_in->off_from = 6000;
  stand_in->off_until = 6700;
  EXPECT_LE(made(), 1e-12);
  EXPECT_GE(statistics.device_faults, 50u);
  EXPECT_GT(statistics.stale_readings, 1900u);
}

TEST_F(ForceDimension, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  Nanoseconds now = std::chrono::seconds(3);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) servo.tick(*opened.device, now += std::chrono::milliseconds(1));
  EXPECT_EQ(test::allocations() - before, 0u);
}

/// A transfer over USB that does not come back.
TEST_F(ForceDimension, ABlockedCallLetsTheForceGo) {
  testing::ScenePeer peer;
  SessionParameters parameters;
  parameters.mode = kUnbounded;
  auto task = std::make_shared<ServoTask>(
      open().device, std::make_shared<Transport>(peer.session(), SessionParameters{}, true),
      parameters, ServoOptions{});
  task->priority = ServoTask::kNoRealTime;
  ServoThread thread(task);
  while (!stand_in->pulls) {
    const auto received = peer.receive();
    if (received.kind == DatagramKind::samples)
      peer.send(testing::ScenePeer::reply_to(received.batch.samples[0], pull(0, 0, 3)));
  }
  stand_in->blocks.store(true);
  test::eventually("it is let go", [&] { return stand_in->blocked && !stand_in->pulls; });
  stand_in->blocks.store(false);
  EXPECT_TRUE(thread.end());
  EXPECT_TRUE(task->result.stood_still);
}

}  // namespace
}  // namespace feltwire::force_dimension_test
