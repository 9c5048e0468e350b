// Tests the messages between a leading hand and a following robot. The messages must arrive
// unchanged, and invalid bytes must be dropped. A client without a robot must send the bytes of
// earlier versions.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "tests/protocol/make.hpp"

namespace feltwire::robot_codec_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

RemoteContact contact() {
  return {.surface = 7,
          .touching = true,
          .point = Vec3(0.1, -0.2, 0.3),
          .normal = Vec3(0.0, -1.0, 0.0),
          .stiffness = 666.5,
          .friction = 0.25,
          .velocity = Vec3(0.0, 0.5, 0.0)};
}

Pose pose(double angle) {
  return {Vec3(0.4, 0.5, 0.6), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitX()))};
}

void expect_same(const RemoteContact& a, const RemoteContact& b) {
  EXPECT_EQ(a.surface, b.surface);
  EXPECT_EQ(a.touching, b.touching);
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.stiffness, b.stiffness);
  EXPECT_EQ(a.friction, b.friction);
}
void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.orientation.coeffs(), b.orientation.coeffs());
}
void expect_same(const EnergyCounters& a, const EnergyCounters& b) {
  EXPECT_EQ(a.given, b.given);
  EXPECT_EQ(a.taken, b.taken);
  EXPECT_EQ(a.pushed, b.pushed);
}

RobotState state() {
  return {.index = 12,
          .time = Nanoseconds(-5),
          .pose = pose(0.5),
          .commanded = pose(0.25),
          .velocity = Vec3(0.5, 0.25, 0.0),
          .angular_velocity = Vec3(1.0, 2.0, 3.0),
          .force = Vec3(-3.0, 2.0, 1.0),
          .torque = Vec3(0.5, 0.0, 0.0),
          .contact = contact(),
          .energy = {.given = 0.1, .taken = 0.7, .pushed = 0.05},
          .gripper = 0.5,
          .gripper_force = 2.5,
          .ok = true,
          .stopped = true};
}
RobotTarget target() {
  return {.index = 3,
          .sample_index = 99,
          .state = LinkState::engaged,
          .pose = pose(-0.5),
          .gripper = 0.5,
          .known_surface = 7,
          .hand_work = 1.25};
}
Lead lead() {
  return {.deadman = true,
          .known_surface = 7,
          .offset = Vec3(0.5, 0.25, -0.5),
          .hand_work = 0.3,
          .gripper = 0.25,
          .seat = 3};
}
Remote remote() {
  return {.state = LinkState::clutched,
          .seat = 2,
          .pose = pose(1.0),
          .contact = contact(),
          .energy = {.given = 1.0, .taken = 2.0, .pushed = 0.5},
          .gripper = 0.5,
          .gripper_force = 2.5,
          .age = 0.125};
}

TEST(RobotCodec, AStateArrivesAsItWas) {
  Encoder encoder;
  RobotState sent = state(), got;
  for (const bool sensed : {true, false}) {
    if (!sensed) sent.force.reset();
    ASSERT_EQ(decode(encoder.state(sent), got), DropReason::none);
    EXPECT_EQ(got.index, sent.index);
    EXPECT_EQ(got.time, sent.time);
    expect_same(got.pose, sent.pose);
    expect_same(got.commanded, sent.commanded);
    EXPECT_EQ(got.velocity, sent.velocity);
    EXPECT_EQ(got.angular_velocity, sent.angular_velocity);
    EXPECT_EQ(got.force, sent.force) << "not sensed is not zero";
    EXPECT_EQ(got.torque, sent.torque);
    expect_same(got.contact, sent.contact);
    expect_same(got.energy, sent.energy);
    EXPECT_EQ(got.gripper, sent.gripper);
    EXPECT_EQ(got.gripper_force, sent.gripper_force);
    EXPECT_TRUE(got.ok && got.stopped);
  }
}

TEST(RobotCodec, ATargetArrivesAsItWas) {
  Encoder encoder;
  RobotTarget got;
  ASSERT_EQ(decode(encoder.target(target()), got), DropReason::none);
  EXPECT_EQ(got.index, 3u);
  EXPECT_EQ(got.sample_index, 99u);
  EXPECT_EQ(got.state, LinkState::engaged);
  expect_same(got.pose, target().pose);
  EXPECT_EQ(got.gripper, 0.5);
  EXPECT_EQ(got.known_surface, 7u);
  EXPECT_EQ(got.hand_work, 1.25);
}

TEST(RobotCodec, ALeadTravelsWithTheSamples) {
  test::Generator random(13);
  Encoder encoder;
  SampleBatch sent = test::random_batch(random, 9, 3, true), got;
  const Bytes without = encoder.samples(sent);
  const std::vector<std::uint8_t> usual(without.begin(), without.end());
  sent.lead = lead();
  ASSERT_EQ(decode(encoder.samples(sent), got), DropReason::none);
  ASSERT_TRUE(got.lead);
  EXPECT_TRUE(got.lead->deadman);
  EXPECT_EQ(got.lead->known_surface, 7u);
  EXPECT_EQ(got.lead->offset, lead().offset);
  EXPECT_EQ(got.lead->hand_work, 0.3);
  EXPECT_EQ(got.lead->gripper, 0.25);
  EXPECT_EQ(got.lead->seat, 3);
  sent.lead.reset();
  const Bytes again = encoder.samples(sent);
  EXPECT_EQ(std::vector<std::uint8_t>(again.begin(), again.end()), usual);
  ASSERT_EQ(decode(again, got), DropReason::none);
  EXPECT_FALSE(got.lead);
}

TEST(RobotCodec, ARobotTravelsWithTheReply) {
  Encoder encoder;
  Reply sent, got;
  sent.sample_index = 1;
  const std::size_t usual = encoder.reply(sent).size();
  sent.remote = remote();
  const Bytes payload = encoder.reply(sent);
  EXPECT_LE(payload.size(), usual + 176) << "160 bytes, a place in the table, and padding";
  ASSERT_EQ(decode(payload, got), DropReason::none);
  ASSERT_TRUE(got.remote);
  EXPECT_EQ(got.remote->state, LinkState::clutched);
  expect_same(got.remote->pose, remote().pose);
  expect_same(got.remote->contact, remote().contact);
  expect_same(got.remote->energy, remote().energy);
  EXPECT_EQ(got.remote->gripper, 0.5);
  EXPECT_EQ(got.remote->gripper_force, 2.5);
  EXPECT_EQ(got.remote->age, 0.125);
  EXPECT_TRUE(got.remote->meets_surfaces);
  EXPECT_EQ(got.remote->seat, 2);
  sent.remote->meets_surfaces = false;
  ASSERT_EQ(decode(encoder.reply(sent), got), DropReason::none);
  EXPECT_FALSE(got.remote->meets_surfaces);
  EXPECT_EQ(got.remote->state, LinkState::clutched);
  EXPECT_EQ(got.remote->seat, 2);
  sent.remote.reset();
  EXPECT_EQ(encoder.reply(sent).size(), usual);
  ASSERT_EQ(decode(encoder.reply(sent), got), DropReason::none);
  EXPECT_FALSE(got.remote);
}

TEST(RobotCodec, WhatTheHandHasToTurnTravelsWithTheRobot) {
  Encoder encoder;
  Reply sent, got;
  sent.sample_index = 1;
  sent.remote = remote();
  sent.remote->state = LinkState::aligning;
  sent.remote->turn = Vec3(0.5, -0.25, 3.0);
  ASSERT_EQ(decode(encoder.reply(sent), got), DropReason::none);
  EXPECT_EQ(got.remote->state, LinkState::aligning);
  EXPECT_EQ(got.remote->turn, sent.remote->turn);
  for (const Vec3& bad : {Vec3(3.0, 1.0, 0.0), Vec3(kNan, 0.0, 0.0), Vec3(kInfinity, 0.0, 0.0)}) {
    sent.remote->turn = bad;
    EXPECT_EQ(decode(encoder.reply(sent), got), DropReason::not_finite) << bad.transpose();
  }
  sent.remote->turn.reset();
  ASSERT_EQ(decode(encoder.reply(sent), got), DropReason::none);
  EXPECT_FALSE(got.remote->turn);
}

OtherSurfaces others() {
  OtherSurfaces other;
  other.count = OtherSurfaces::kMost;
  other.surfaces.fill(contact());
  for (RemoteContact& surface : other.surfaces) surface.touching = false;
  other.surfaces[1].surface = 3;
  other.surfaces[1].normal = Vec3(1.0, 0.0, 0.0);
  return other;
}

TEST(RobotCodec, SurfacesBesideTheContactArriveAsTheyWere) {
  Encoder encoder;
  RobotState state_sent = state(), state_got;
  Reply reply_sent, reply_got;
  reply_sent.sample_index = 1;
  reply_sent.remote = remote();
  const std::size_t usual = encoder.state(state_sent).size();
  for (const int count : {2, 1, 0}) {
    state_sent.others = others();
    state_sent.others.count = count;
    reply_sent.remote->others = state_sent.others;
    EXPECT_EQ(encoder.state(state_sent).size() == usual, count == 0) << "none takes no byte";
    ASSERT_EQ(decode(encoder.state(state_sent), state_got), DropReason::none);
    ASSERT_EQ(decode(encoder.reply(reply_sent), reply_got), DropReason::none);
    ASSERT_EQ(state_got.others.count, count);
    ASSERT_EQ(reply_got.remote->others.count, count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      expect_same(state_got.others.surfaces[i], others().surfaces[i]);
      expect_same(reply_got.remote->others.surfaces[i], others().surfaces[i]);
    }
  }
}

TEST(RobotCodec, SurfacesThatCannotBeAreRefused) {
  using Wrong = void (*)(RemoteContact&);
  Encoder encoder;
  for (const Wrong wrong : {Wrong([](RemoteContact& c) { c.surface = 0; }),
                            Wrong([](RemoteContact& c) { c.touching = true; }),
                            Wrong([](RemoteContact& c) { c.normal *= 1.1; }),
                            Wrong([](RemoteContact& c) { c.point.y() = kNan; }),
                            Wrong([](RemoteContact& c) { c.stiffness = 0.0; }),
                            Wrong([](RemoteContact& c) { c.friction = kInfinity; })}) {
    RobotState sent = state(), got;
    sent.others = others();
    wrong(sent.others.surfaces[1]);
    EXPECT_EQ(decode(encoder.state(sent), got), DropReason::not_finite);
    Reply reply, back;
    reply.sample_index = 1;
    reply.remote = remote();
    reply.remote->others = sent.others;
    EXPECT_EQ(decode(encoder.reply(reply), back), DropReason::not_finite);
  }
}

RemoteWall wall(std::uint32_t number) {
  return {{Vec3(0.0, 0.0, -1.0), -0.25}, 1000.0, 0.0078125, number};
}

TEST(RobotCodec, WallsTravelWithTheRobot) {
  Encoder encoder;
  Reply sent, got;
  sent.sample_index = 1;
  sent.remote = remote();
  const std::size_t usual = encoder.reply(sent).size();
  sent.remote->wall_count = 3;
  for (std::uint32_t i = 0; i < 3; ++i) sent.remote->walls[i] = wall(7 + i);
  const Bytes payload = encoder.reply(sent);
  EXPECT_LE(payload.size(), usual + 3 * 32 + 32) << "a vector, and padding";
  ASSERT_EQ(decode(payload, got), DropReason::none);
  ASSERT_EQ(got.remote->wall_count, 3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(got.remote->walls[i].wall.normal, wall(0).wall.normal);
    EXPECT_EQ(got.remote->walls[i].wall.distance, wall(0).wall.distance);
    EXPECT_EQ(got.remote->walls[i].stiffness, 1000.0);
    EXPECT_EQ(got.remote->walls[i].depth, 0.0078125);
    EXPECT_EQ(got.remote->walls[i].number, 7 + i);
  }
  sent.remote->wall_count = 0;
  EXPECT_EQ(encoder.reply(sent).size(), usual);
  ASSERT_EQ(decode(encoder.reply(sent), got), DropReason::none);
  EXPECT_EQ(got.remote->wall_count, 0);
}

TEST(RobotCodec, RefusesWallsThatAreNone) {
  Encoder encoder;
  const std::vector<std::function<void(RemoteWall&)>> wrong = {
      [](RemoteWall& w) { w.wall.normal *= 1.1; },
      [](RemoteWall& w) { w.wall.normal.setZero(); },
      [](RemoteWall& w) { w.wall.normal.x() = kNan; },
      [](RemoteWall& w) { w.wall.distance = kInfinity; },
      [](RemoteWall& w) { w.wall.distance = 1001.0; },
      [](RemoteWall& w) { w.stiffness = 0.0; },
      [](RemoteWall& w) { w.stiffness = 1e10; },
      [](RemoteWall& w) { w.stiffness = kNan; },
      [](RemoteWall& w) { w.depth = 0.0; },
      [](RemoteWall& w) { w.depth = 0.2; },
      [](RemoteWall& w) { w.depth = kNan; }};
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    Reply sent, got;
    sent.sample_index = 1;
    sent.remote = remote();
    sent.remote->wall_count = 2;
    sent.remote->walls[0] = sent.remote->walls[1] = wall(1);
    wrong[i](sent.remote->walls[1]);
    EXPECT_EQ(decode(encoder.reply(sent), got), DropReason::not_finite) << i;
  }
}

TEST(RobotCodec, RefusesWhatNoRobotSays) {
  Encoder encoder;
  RobotState got;
  const std::vector<std::function<void(RobotState&)>> wrong = {
      [](RobotState& s) { s.pose.position.x() = kNan; },
      [](RobotState& s) { s.pose.position.y() = 1e4; },
      [](RobotState& s) { s.pose.orientation.coeffs() *= 2.0; },
      [](RobotState& s) { s.commanded.position.z() = kInfinity; },
      [](RobotState& s) { s.commanded.orientation.w() = kNan; },
      [](RobotState& s) { s.velocity.x() = 1e3; },
      [](RobotState& s) { s.angular_velocity.x() = kNan; },
      [](RobotState& s) { s.force = Vec3(0.0, kNan, 0.0); },
      [](RobotState& s) { s.force = Vec3(0.0, 1e7, 0.0); },
      [](RobotState& s) { s.torque.x() = kInfinity; },
      [](RobotState& s) { s.contact.point.x() = kNan; },
      [](RobotState& s) { s.contact.normal = Vec3::Zero(); },
      [](RobotState& s) { s.contact.velocity.x() = kNan; },
      [](RobotState& s) { s.contact.stiffness = 0.0; },
      [](RobotState& s) { s.contact.stiffness = 1e10; },
      [](RobotState& s) { s.contact.friction = -1.0; },
      [](RobotState& s) { s.contact.surface = 0; },  // The robot still reports contact.
      [](RobotState& s) { s.energy.given = kNan; },
      [](RobotState& s) { s.energy.taken = -1.0; },
      [](RobotState& s) { s.energy.pushed = kInfinity; },
      [](RobotState& s) { s.gripper = kNan; },
      [](RobotState& s) { s.gripper_force = kInfinity; }};
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    RobotState sent = state();
    wrong[i](sent);
    EXPECT_EQ(decode(encoder.state(sent), got), DropReason::not_finite) << i;
  }
  RobotState unnumbered = state();
  unnumbered.index = 0;
  EXPECT_EQ(decode(encoder.state(unnumbered), got), DropReason::order);
}

TEST(RobotCodec, RefusesWhatNoServerSays) {
  Encoder encoder;
  RobotTarget got;
  RobotTarget sent = target();
  sent.pose.position.x() = kNan;
  EXPECT_EQ(decode(encoder.target(sent), got), DropReason::not_finite);
  sent = target();
  sent.hand_work = kInfinity;
  EXPECT_EQ(decode(encoder.target(sent), got), DropReason::not_finite);
  sent = target();
  sent.index = 0;
  EXPECT_EQ(decode(encoder.target(sent), got), DropReason::order);
  sent = target();
  sent.state = static_cast<LinkState>(17);
  EXPECT_EQ(decode(encoder.target(sent), got), DropReason::malformed);

  Reply reply, read;
  reply.sample_index = 1;
  reply.remote = remote();
  reply.remote->state = static_cast<LinkState>(7);
  EXPECT_EQ(decode(encoder.reply(reply), read), DropReason::not_finite);
  reply.remote = remote();
  reply.remote->age = -1.0;
  EXPECT_EQ(decode(encoder.reply(reply), read), DropReason::not_finite);
  reply.remote = remote();
  reply.remote->contact.stiffness = kNan;
  EXPECT_EQ(decode(encoder.reply(reply), read), DropReason::not_finite);
}

TEST(RobotCodec, RefusesALeadThatIsNone) {
  test::Generator random(14);
  Encoder encoder;
  SampleBatch sent = test::random_batch(random, 9, 1, false), got;
  const std::vector<std::function<void(Lead&)>> wrong = {
      [](Lead& l) { l.offset.x() = kNan; }, [](Lead& l) { l.offset.y() = 1e5; },
      [](Lead& l) { l.hand_work = kInfinity; }, [](Lead& l) { l.gripper = kNan; }};
  for (const auto& spoil : wrong) {
    sent.lead = lead();
    spoil(*sent.lead);
    EXPECT_EQ(decode(encoder.samples(sent), got), DropReason::not_finite);
  }
}

TEST(RobotCodec, AllThatALeaderSaysAndHearsFitsADatagram) {
  Encoder encoder;
  test::Generator random(41);
  SampleBatch batch = test::random_batch(random, kMaxRedundancy + 1, 9, true);
  batch.report = HandReport{};
  batch.lead = Lead{};
  EXPECT_LE(encoder.samples(batch).size(), kMaxPayload);

  Reply reply;
  reply.sample_index = reply.withheld = 1;
  reply.rotation = reply.predicted = reply.modelled = true;
  reply.model.count = kMaxPatches;
  for (int i = 0; i < 3; ++i) reply.normals.add(Vec3::Unit(i));
  reply.remote.emplace().contact = contact();
  reply.remote->others = others();
  reply.remote->wall_count = kMostRemoteWalls;
  for (RemoteWall& w : reply.remote->walls) w = wall(1);
  for (SurfacePatch& patch : reply.model.patches) patch.offset = 1e-3;
  reply.change = ClientChange{
      1, LawChoice{.mode = MethodName(std::string(kLongestMethodName, 'm'))}, LinkQuality{}};
  EXPECT_LE(encoder.reply(reply).size(), kMaxPayload);
}

}  // namespace
}  // namespace feltwire::robot_codec_test
