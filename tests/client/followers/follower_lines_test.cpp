// Tests the text lines between feltwire and a robot driver.

#include "client/followers/follower_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>

namespace feltwire::follower_lines {
namespace {

using ::testing::HasSubstr;

const std::string kHello = "follower 1 name=arm period=0.005 stiffness=800";
const std::string kState = "state 7 pose=1,2,3,1,0,0,0 commanded=1,2,4,0,1,0,0";

void expect_fault(const std::optional<Fault>& fault, const std::string& field,
                  const std::string& what) {
  ASSERT_TRUE(fault) << field;
  EXPECT_EQ(fault->field, field);
  EXPECT_THAT(std::string(fault->what), HasSubstr(what));
}

TEST(FollowerLines, AHelloIsTheSpecification) {
  FollowerSpec spec;
  ASSERT_FALSE(read_hello(kHello + " damping=60 own_damping=2 mass=1.5 senses_wrench=0 "
                                   "wrench_noise=0.1 gripper=0.08",
                          spec));
  EXPECT_EQ(spec.name, "arm");
  EXPECT_EQ(spec.servo_period, 0.005);
  EXPECT_EQ(spec.stiffness, 800.0);
  EXPECT_EQ(spec.damping, 60.0);
  EXPECT_EQ(spec.own_damping, 2.0);
  EXPECT_EQ(spec.mass, 1.5);
  EXPECT_FALSE(spec.senses_wrench);
  EXPECT_EQ(spec.wrench_noise, 0.1);
  EXPECT_EQ(spec.gripper_opening, 0.08);
}

TEST(FollowerLines, AHelloWithAFaultIsNamed) {
  const auto fault = [](const std::string& line) {
    static FollowerSpec spec;
    return read_hello(line, spec);
  };
  expect_fault(fault("hello"), "follower", "not the first word");
  expect_fault(fault("follower 2 name=x"), "follower", "another version");
  expect_fault(fault("follower 1 name=x stiffness=1"), "period", "missing");
  expect_fault(fault("follower 1 name=x period=0.01"), "stiffness", "missing");
  expect_fault(fault("follower 1 period=0.01 stiffness=1"), "name", "missing");
  expect_fault(fault("follower 1 name=x stiffness=1 period=0.2"), "period", "20 states a second");
  expect_fault(fault(kHello + " mass=-1"), "mass", "negative");
  expect_fault(fault(kHello + " mass=nan"), "mass", "no finite number");
  expect_fault(fault(kHello + " stiffness=1"), "stiffness", "twice");
  expect_fault(fault(kHello + " colour=red"), "colour", "no field");
  expect_fault(fault(kHello + " colour"), "colour", "NAME=VALUE");
  expect_fault(fault("follower 1 name= period=0.01 stiffness=1"), "name", "no name");
}

TEST(FollowerLines, AStateIsAReading) {
  std::uint64_t number = 0;
  FollowerReading r;
  ASSERT_FALSE(read_state(kState + " velocity=0.1,0,-0.1 turning=0,0,1 force=1,-2e-3,3 "
                                   "torque=0,0.5,0 gripper=0.04 grip=12 ok=0 stopped=1",
                          number, r));
  EXPECT_EQ(number, 7u);
  EXPECT_EQ(r.pose.position, Vec3(1, 2, 3));
  EXPECT_EQ(r.commanded.position, Vec3(1, 2, 4));
  EXPECT_EQ(r.commanded.orientation.x(), 1.0);
  EXPECT_EQ(r.velocity, Vec3(0.1, 0, -0.1));
  EXPECT_EQ(r.angular_velocity, Vec3(0, 0, 1));
  EXPECT_EQ(r.force.value_or(Vec3::Zero()), Vec3(1, -2e-3, 3));
  EXPECT_EQ(r.torque, Vec3(0, 0.5, 0));
  EXPECT_EQ(r.gripper, 0.04);
  EXPECT_EQ(r.gripper_force, 12.0);
  EXPECT_FALSE(r.ok);
  EXPECT_TRUE(r.stopped);
  // A line without a force differs from a force of zero.
  ASSERT_FALSE(read_state(kState, number, r));
  EXPECT_FALSE(r.force);
  EXPECT_TRUE(r.ok);
}

TEST(FollowerLines, AStateWithAFaultIsNamedAndChangesNothing) {
  std::uint64_t number = 3;
  FollowerReading r;
  r.gripper = 0.5;
  const auto fault = [&](const std::string& line) { return read_state(line, number, r); };
  expect_fault(fault("stat 1"), "state", "not the first word");
  expect_fault(fault("state x"), "state", "no number");
  expect_fault(fault("state 1 commanded=0,0,0,1,0,0,0"), "pose", "missing");
  expect_fault(fault("state 1 pose=0,0,0,1,0,0,0"), "commanded", "missing");
  expect_fault(fault("state 1 pose=0,0,0,1,0,0"), "pose", "seven finite numbers");
  expect_fault(fault("state 1 pose=0,0,0,1,0,0,0,0"), "pose", "seven finite numbers");
  expect_fault(fault("state 1 pose=0,0,0,2,0,0,0"), "pose", "unit quaternion");
  expect_fault(fault("state 1 pose=0,0,2000,1,0,0,0"), "pose", "use metres");
  expect_fault(fault(kState + " force=1,2"), "force", "three finite numbers");
  expect_fault(fault(kState + " force=1,2,inf"), "force", "three finite numbers");
  expect_fault(fault(kState + " force=1,2,3x"), "force", "three finite numbers");
  expect_fault(fault(kState + " ok=yes"), "ok", "neither 0 nor 1");
  expect_fault(fault(kState + " grip=-1"), "grip", "negative");
  expect_fault(fault(kState + " ok=1 ok=1"), "ok", "twice");
  expect_fault(fault(kState + "  ok=1"), "", "NAME=VALUE");  // The line has two blanks.
  EXPECT_EQ(number, 3u);
  EXPECT_EQ(r.gripper, 0.5);
}

TEST(FollowerLines, ATargetIsExact) {
  FollowerTarget target{{Vec3(0.1, -1.0 / 3.0, 2e-9), Quaternion::Identity()}, 0.04};
  std::array<char, kLongestLine> room{};
  const std::string line(room.data(), write_target(12, target, room));
  EXPECT_EQ(line, "target 12 pose=0.1,-0.3333333333333333,2e-09,1,0,0,0 gripper=0.04\n");
  std::array<char, 20> small{};
  EXPECT_EQ(write_target(12, target, small), 0u);
}

void feed(Lines& lines, std::string_view text) {
  const std::span<char> room = lines.room();
  ASSERT_LE(text.size(), room.size());
  std::memcpy(room.data(), text.data(), text.size());
  lines.added(text.size());
}

TEST(FollowerLines, BytesBecomeLines) {
  Lines lines;
  feed(lines, "one\n\ntw");
  auto line = lines.next();
  ASSERT_TRUE(line);
  EXPECT_EQ(line->text, "one");
  EXPECT_EQ(line->number, 1u);
  EXPECT_FALSE(lines.next());
  feed(lines, "o\r\nthree\n");
  line = lines.next();
  ASSERT_TRUE(line);
  EXPECT_EQ(line->text, "two");
  EXPECT_EQ(line->number, 3u) << "empty lines count";
  EXPECT_EQ(lines.next()->text, "three");
  EXPECT_FALSE(lines.next());
}

TEST(FollowerLines, ALineWithoutEndIsSaidOnceAndLeftOut) {
  Lines lines;
  const std::string much(kLongestLine, 'x');
  feed(lines, "first\n" + much);
  EXPECT_EQ(lines.next()->text, "first");
  auto line = lines.next();
  ASSERT_TRUE(line);
  EXPECT_TRUE(line->too_long);
  EXPECT_EQ(line->number, 2u);
  for (int i = 0; i < 10; ++i) {
    feed(lines, much);
    EXPECT_FALSE(lines.next());
  }
  feed(lines, "rest\nlast\n");
  line = lines.next();
  ASSERT_TRUE(line);
  EXPECT_EQ(line->text, "last");
  EXPECT_EQ(line->number, 3u);
}

}  // namespace
}  // namespace feltwire::follower_lines
