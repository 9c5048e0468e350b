// Tests the first stage of a tick alone: readings become movements or faults.

#include "client/servo/device_input.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/device/device_file.hpp"

namespace feltwire::device_input_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

DeviceReading at(double x) {
  DeviceReading reading;
  reading.pose.position = Vec3(x, 0, 0);
  return reading;
}

struct Input {
  DeviceMovement take(const DeviceReading& reading) { return input.take(reading, kPeriod, counts); }
  DeviceInput input{builtin_device("sigma.7"), 1.0, true, kPeriod};
  DeviceCounts counts;
};

TEST(DeviceInput, TellsTheMovementSinceTheLastTick) {
  Input all;
  const DeviceMovement first = all.take(at(0.01));
  EXPECT_TRUE(first.read);
  EXPECT_FALSE(first.known) << "nothing came before";
  DeviceReading next = at(0.0105);
  const double angle = 0.002;  // [rad]
  next.pose.orientation = Quaternion(std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle));
  const DeviceMovement second = all.take(next);
  EXPECT_TRUE(second.known);
  EXPECT_NEAR(second.displacement.x(), 0.0005, 1e-15);
  EXPECT_NEAR(second.rotation.z(), angle, 1e-12);
  EXPECT_EQ(all.input.pose().position, next.pose.position);
  EXPECT_EQ(all.counts.faults, 0u);
}

TEST(DeviceInput, NormalizesTheOrientation) {
  Input all;
  DeviceReading reading = at(0.0);
  reading.pose.orientation = Quaternion(2, 0, 0, 0);
  EXPECT_TRUE(all.take(reading).read);
  EXPECT_EQ(all.input.pose().orientation.w(), 1.0);
}

TEST(DeviceInput, AFaultHidesTheMovementAcrossIt) {
  Input all;
  all.take(at(0.0));
  DeviceReading bad = at(0.0);
  bad.pose.position.y() = std::numeric_limits<double>::quiet_NaN();
  const DeviceMovement fault = all.take(bad);
  EXPECT_FALSE(fault.read);
  EXPECT_TRUE(fault.fault);
  EXPECT_FALSE(all.input.position_known());
  EXPECT_EQ(all.input.no_position_for(), kPeriod);
  const DeviceMovement after = all.take(at(0.02));
  EXPECT_TRUE(after.read);
  EXPECT_FALSE(after.known);
  EXPECT_TRUE(after.displacement.isZero(0.0));
  EXPECT_EQ(all.input.no_position_for(), 0.0);
  EXPECT_EQ(all.counts.faults, 1u);
}

TEST(DeviceInput, AJumpIsAFaultThatNamesItself) {
  Input all;
  all.take(at(0.0));
  const DeviceMovement jump = all.take(at(0.05));  // a speed of 50 m/s
  EXPECT_TRUE(jump.jumped);
  EXPECT_FALSE(jump.read);
  EXPECT_EQ(all.counts.jumps, 1u);
  EXPECT_EQ(all.counts.faults, 1u);
  EXPECT_EQ(all.input.pose().position.x(), 0.0) << "the place before stays";
  DeviceReading judged = at(0.0);
  judged.jumped = true;  // The driver itself has already checked this jump.
  EXPECT_TRUE(all.take(judged).jumped);
}

/// A device with a clutch or a withheld force reports its own reason for zero force.
TEST(DeviceInput, AReasonOfTheDeviceIsNoFault) {
  Input all;
  all.take(at(0.0));
  DeviceReading clutched = at(0.01);
  clutched.clutched = true;
  EXPECT_FALSE(all.take(clutched).fault);
  EXPECT_EQ(all.input.pose().position.x(), 0.0) << "the tool stands";
  DeviceReading starting = at(0.02);
  starting.withheld = Withheld::starting;
  EXPECT_FALSE(all.take(starting).fault);
  EXPECT_EQ(all.input.pose().position.x(), 0.02) << "it is shown";
  DeviceReading not_homed = at(0.03);
  not_homed.withheld = Withheld::not_homed;
  EXPECT_FALSE(all.take(not_homed).fault);
  EXPECT_EQ(all.input.pose().position.x(), 0.02);
  DeviceReading ended;
  ended.ended = true;
  ended.ok = false;
  EXPECT_FALSE(all.take(ended).fault);
  EXPECT_TRUE(all.input.ended());
  EXPECT_EQ(all.counts.faults, 0u);
}

TEST(DeviceInput, WaitsForANewReadingButNotForEver) {
  Input all;
  DeviceReading repeated = at(0.0);
  repeated.fresh = false;
  EXPECT_FALSE(all.input.waits(repeated, 0.0, 0.025, all.counts)) << "no place is known";
  all.take(at(0.0));
  EXPECT_TRUE(all.input.waits(repeated, 0.024, 0.025, all.counts));
  EXPECT_FALSE(all.input.waits(repeated, 0.025, 0.025, all.counts));
  EXPECT_FALSE(all.input.waits(at(0.0), 0.0, 0.025, all.counts));
  EXPECT_EQ(all.counts.stale_readings, 2u);
}

}  // namespace
}  // namespace feltwire::device_input_test
