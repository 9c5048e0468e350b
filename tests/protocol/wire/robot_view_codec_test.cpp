// Tests a robot in an observer's view as bytes.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/scene_view.hpp"
#include "tests/protocol/make.hpp"

namespace feltwire::robot_view_codec_test {
namespace {

using test::float_vector;
using test::Generator;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

Pose random_pose(Generator& random) {
  Pose pose;
  pose.position = float_vector(random, 1);
  pose.orientation = Quaternion(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                                test::uniform(random, -1, 1), test::uniform(random, 0.1, 1))
                         .normalized();
  return pose;
}

SceneView view_of(std::size_t hands, Generator& random) {
  SceneView view;
  view.hands_end = SceneView::kLastHand;
  view.hand_count = hands;
  for (std::size_t i = 0; i < hands; ++i)
    view.hand[i] = {static_cast<std::uint32_t>(4 + 2 * i), random_pose(random),
                    float_vector(random, 10)};
  return view;
}

Reply any_reply() {
  Reply reply;
  reply.sample_index = 1;
  return reply;
}

void expect_near(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_LE((a.orientation.coeffs() - b.orientation.coeffs()).norm(), 1e-6);
}

SeenRobot robot_of(Generator& random) {
  SeenRobot robot;
  robot.pose = random_pose(random);
  robot.target = random_pose(random);
  robot.force = float_vector(random, 10);
  robot.torque = float_vector(random, 1);
  robot.state = LinkState::clutched;
  robot.hand = 9;
  robot.stopped = robot.touches = true;
  robot.gripper = 0.25;
  robot.age = 0.125;
  robot.seat = 2;
  robot.seats = 0b1101;
  return robot;
}

TEST(RobotViewCodec, ARobotRoundTrips) {
  Generator random(37);
  Encoder encoder;
  Reply reply;
  SceneView got, sent = view_of(2, random);
  const std::size_t usual = encoder.reply(any_reply(), &sent).size();
  sent.robot = robot_of(random);
  for (const bool sensed : {true, false}) {
    if (!sensed) sent.robot->force.reset();
    const Bytes payload = encoder.reply(any_reply(), &sent);
    EXPECT_LE(payload.size(), usual + kSeenRobotRoom);
    ASSERT_EQ(decode(payload, reply, &got), DropReason::none);
    ASSERT_TRUE(got.robot);
    expect_near(got.robot->pose, sent.robot->pose);
    expect_near(got.robot->target, sent.robot->target);
    EXPECT_EQ(got.robot->force, sent.robot->force) << "not sensed is not zero";
    EXPECT_EQ(got.robot->torque, sent.robot->torque);
    EXPECT_EQ(got.robot->state, LinkState::clutched);
    EXPECT_EQ(got.robot->hand, 9u);
    EXPECT_TRUE(got.robot->ok && got.robot->stopped && got.robot->touches);
    EXPECT_EQ(got.robot->gripper, 0.25);
    EXPECT_EQ(got.robot->age, 0.125);
    EXPECT_EQ(got.robot->seat, 2);
    EXPECT_EQ(got.robot->seats, 0b1101);
    EXPECT_EQ(got.hand_count, 2u);
  }
  sent.robot.reset();
  EXPECT_EQ(encoder.reply(any_reply(), &sent).size(), usual);
  ASSERT_EQ(decode(encoder.reply(any_reply(), &sent), reply, &got), DropReason::none);
  EXPECT_FALSE(got.robot) << "of the view before";
}

TEST(RobotViewCodec, RefusesARobotThatIsNone) {
  Generator random(38);
  Encoder encoder;
  const std::vector<std::function<void(SeenRobot&)>> wrong = {
      [](SeenRobot& r) { r.pose.position.x() = kNotANumber; },
      [](SeenRobot& r) { r.pose.orientation.coeffs() *= 2.0; },
      [](SeenRobot& r) { r.target.position.y() = kInfinity; },
      [](SeenRobot& r) { r.target.orientation.coeffs().setZero(); },
      [](SeenRobot& r) { r.force->z() = kNotANumber; },
      [](SeenRobot& r) { r.torque.z() = kInfinity; },
      [](SeenRobot& r) { r.state = static_cast<LinkState>(7); },
      [](SeenRobot& r) { r.gripper = kNotANumber; },
      [](SeenRobot& r) { r.age = -1.0; },
      [](SeenRobot& r) { r.seat = 1; },  // This number has no robot.
      [](SeenRobot& r) { r.seat = 200; },
      [](SeenRobot& r) { r.age = kInfinity; }};
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    Reply reply;
    SceneView got, sent = view_of(1, random);
    sent.robot = robot_of(random);
    wrong[i](*sent.robot);
    EXPECT_EQ(decode(encoder.reply(any_reply(), &sent), reply, &got), DropReason::not_finite) << i;
  }
}

}  // namespace
}  // namespace feltwire::robot_view_codec_test
