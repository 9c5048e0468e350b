// Tests Force Dimension's driver against a substitute of the maker's library.

#include <gmock/gmock.h>

#include "tests/devices/force_dimension_bench.hpp"
#include "tests/devices/identified.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::force_dimension_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(ForceDimension, IsMadeReadyWithoutAKick) {
  {
    const OpenedDevice opened = open();
    EXPECT_EQ(opened.device->spec().name, "omega.7");
    EXPECT_EQ(opened.device->spec().rotation_sensed, 3);
    EXPECT_EQ(opened.device->longest_tick(), Nanoseconds(0));
    EXPECT_TRUE(stand_in->force_on && stand_in->gravity_on);
    EXPECT_FALSE(stand_in->brakes_on || stand_in->force_before_on);
    EXPECT_EQ(stand_in->max_force, 12.0);
    EXPECT_EQ(stand_in->watchdog, 80);  // 10 ms in units of the watchdog
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
  // The model is unknown. The driver has only the number of its motors.
  stand_in->system = "lambda.9";
  const OpenedDevice other = open();
  EXPECT_EQ(other.device->spec().rotation_actuated, 3);
  EXPECT_EQ(other.device->spec().rotation.least_inertia, 0.0);
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

TEST_F(ForceDimension, TheLagOfItsBusIsAssumed) {
  EXPECT_EQ(open().device->spec().actuation.lag, 0.5e-3);
  EXPECT_THAT(open().notes,
              Contains(HasSubstr("actuation_lag 0.0005 s is an assumption for USB; ")));
  // Under the maker's library, a Falcon has no late ticks but a slow bus.
  stand_in->system = "Falcon";
  const OpenedDevice falcon = open();
  EXPECT_EQ(falcon.device->spec().actuation.late_ticks, 0);
  EXPECT_EQ(falcon.device->spec().actuation.lag, 1.5e-3);
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
  ::setenv("FDSDK", "/proc/nowhere", 1);
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

TEST_F(ForceDimension, TheSecondOfTwoIsTheSecond) {
  stand_in->devices = 2;
  stand_in->left_handed = true;
  const OpenedDevice opened = open("1");
  EXPECT_THAT(opened.notes, Contains(HasSubstr("left-handed")));
  EXPECT_EQ(opened.device->write(pull(0, 0, 1)), pull(0, 0, 1));
  EXPECT_TRUE(opened.device->read({}).ok);
  EXPECT_EQ(stand_in->strangers, 0);
  EXPECT_THAT(refusal("2"), HasSubstr("no device found"));
}

TEST_F(ForceDimension, IdentifyMeasuresAFreeHandle) {
  testing::let_free(stand_in->mass);
  const OpenedDevice opened = open();
  testing::Identified identified(*opened.device);
  identified.run(*opened.device,
                 [&] { return static_cast<double>(stand_in->readings) * stand_in->period; });
  identified.expect_below(stand_in->mass);
}

TEST_F(ForceDimension, MakesNoEnergy) {
  EXPECT_GT(made(kUnbounded), 0.01);  // The measurement can fail.
  stand_in->mass = {};
  EXPECT_LE(made(), 1e-12);
  EXPECT_GT(stand_in->mass.largest_force, 0.5);
  EXPECT_EQ(statistics.device.faults, 0u);
  EXPECT_NEAR(static_cast<double>(statistics.samples), 60e3, 1.0);  // No tick may be missing.
}

/// The wrist hits a late stop and the hand hits a late wall. Both act at a single port.
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

TEST_F(ForceDimension, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  Nanoseconds now = std::chrono::seconds(3);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) servo.tick(*opened.device, now += std::chrono::milliseconds(1));
  EXPECT_EQ(test::allocations() - before, 0u);
}

}  // namespace
}  // namespace feltwire::force_dimension_test
