// Tests the third stage of a tick alone: the scene's command at a pose, from reply and local model.

#include "client/servo/virtual_environment.hpp"

#include <gtest/gtest.h>

#include "client/servo/servo_law.hpp"
#include "core/device/device_file.hpp"

namespace feltwire::virtual_environment_test {
namespace {

constexpr double kStiffness = 1000.0;  // [N/m]

SessionParameters modelled() {
  SessionParameters p;
  p.mode = "none";
  p.local_model = true;
  return p;
}

/// Returns a floor at z = 0 that is valid within 40 mm of the origin. The reply's own command is 7
/// N.
Reply floor_reply() {
  Reply reply;
  reply.sample_index = 1;
  reply.command.elastic = Vec3(0, 0, 7);
  reply.modelled = true;
  reply.model.reach = 0.04;
  reply.model.count = 1;
  reply.model.patches[0].radius = 0.1;
  reply.model.patches[0].material.stiffness = kStiffness;
  return reply;
}

struct Floor {
  explicit Floor(const SessionParameters& p = modelled(), const Reply& reply = floor_reply())
      : parameters(p), environment(spec, p, options), law(spec, p, options) {
    replies.made(1, now);
    replies.take(reply, now, {.newest_sample = 1, .last_tick = now}, p.hold_time,
                 statistics.replies);
    environment.take(replies, 1, p.hold_time, statistics.local_model);
  }
  Command at(const Vec3& place) {
    BoundingStep step;
    step.hold_time = parameters.servo_period;
    step.displacement = place - pose.position;
    pose.position = place;
    const Command command = environment.command(step, law.bounding, pose, replies, parameters, now,
                                                statistics.local_model);
    local = step.local;
    return command;
  }
  SessionParameters parameters;
  DeviceSpec spec = builtin_device("simulated");
  ServoOptions options;
  VirtualEnvironment environment;
  ServoLaw law;
  ReplyIntake replies{1e-3, false};
  ServoStatistics statistics;
  Nanoseconds now{1'000'000'000};
  Pose pose;
  bool local = false;
};

TEST(VirtualEnvironment, TheModelAnswersWhereTheDeviceIsNow) {
  Floor floor;
  for (const double depth : {0.0, 1e-3, 3e-3}) {
    EXPECT_NEAR(floor.at({0.002, 0, -depth}).elastic.z(), kStiffness * depth, 1e-12);
    EXPECT_TRUE(floor.local);
    EXPECT_TRUE(floor.environment.near());
  }
  EXPECT_EQ(floor.statistics.local_model.from_model, 3u);
  EXPECT_EQ(floor.statistics.local_model.hand_overs, 1u);
}

TEST(VirtualEnvironment, BeyondTheReachTheReplyAnswers) {
  Floor floor;
  floor.at({0, 0, -1e-3});
  EXPECT_EQ(floor.at({0.05, 0, -1e-3}).elastic.z(), 7.0);
  EXPECT_FALSE(floor.environment.near());
  EXPECT_EQ(floor.statistics.local_model.beyond_reach, 1u);
  EXPECT_EQ(floor.statistics.local_model.hand_overs, 2u);
}

TEST(VirtualEnvironment, WithoutLocalModelTheReplyAnswers) {
  SessionParameters p = modelled();
  p.local_model = false;
  Floor floor(p);
  EXPECT_EQ(floor.at({0, 0, -1e-3}).elastic.z(), 7.0);
  EXPECT_FALSE(floor.local);
  EXPECT_EQ(floor.statistics.local_model.from_model + floor.statistics.local_model.beyond_reach,
            0u);
}

TEST(VirtualEnvironment, WhatIsForgottenAnswersNoMore) {
  Floor floor;
  floor.at({0, 0, -1e-3});
  floor.environment.forget();
  EXPECT_EQ(floor.at({0, 0, -1e-3}).elastic.z(), 7.0);
}

/// If the model's force begins while the tool rests, the force must not rise faster than a fade
/// falls.
TEST(VirtualEnvironment, AForceThatComesUnderARestingHandRisesSlowly) {
  Floor floor;
  floor.at({0, 0, -3e-3});
  BoundingStep step;
  step.hold_time = floor.parameters.servo_period;
  step.command = floor.at({0, 0, -3e-3});
  const double slew = largest_slew(floor.spec.max_force, floor.parameters);
  const Command first = floor.environment.rise_limited(step, floor.replies);
  EXPECT_NEAR(first.elastic.z(), slew * step.hold_time, 1e-9);
  const Command second = floor.environment.rise_limited(step, floor.replies);
  EXPECT_NEAR(second.elastic.z(), 2.0 * slew * step.hold_time, 1e-9);
}

TEST(VirtualEnvironment, AHandThatLeadsNeedsTheLocalModel) {
  SessionParameters p = modelled();
  p.local_model = false;
  ServoOptions options;
  options.leads.emplace();
  EXPECT_THROW(VirtualEnvironment(builtin_device("simulated"), p, options), std::invalid_argument);
  p.local_model = true;
  const VirtualEnvironment leads(builtin_device("simulated"), p, options);
  EXPECT_NE(leads.robot(), nullptr);
  EXPECT_EQ(Floor().environment.robot(), nullptr);
}

}  // namespace
}  // namespace feltwire::virtual_environment_test
