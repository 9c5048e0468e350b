// The descriptions of sessions and scenes for observers must arrive unchanged.

#include <gtest/gtest.h>

#include "protocol/wire/control.hpp"
#include "tests/protocol/control_messages.hpp"

namespace feltwire::control {
namespace {

using test::body;
using test::round_trip;
using test::unusual_parameters;

/// The largest number of the longest descriptions must fit in a frame and its limits.
TEST(Control, SessionDescriptionsAreReadAsWritten) {
  SessionDescription one;
  one.number = 7;
  one.session = 0x0123456789abcdef;
  one.client = std::string(kMaxName, 'c');
  one.device = std::string(kMaxName, 'd');
  one.tool = std::string(kMaxName, 't');
  one.role = Role::observer;
  one.parameters = unusual_parameters();
  one.parameters.mode = std::string(kLongestMethodName, 'm');
  one.samples = 8;
  one.missed = 9;
  one.round_trip = 0.25;
  one.delivered = -0.5;
  one.burned = 0.75;
  one.balance = 1.5;
  one.seconds = 12.5;
  one.hand_damping = 0.125;
  one.times = {{1, 2, 3, 4, 5, 6, 7, std::uint64_t{1} << 40}, {9, 8, 7, 6, 5, 4, 3, 2}};
  const auto read = round_trip(SessionDescriptions{std::vector(kMaxDescriptions, one), true});
  EXPECT_TRUE(read.more);
  ASSERT_EQ(read.sessions.size(), kMaxDescriptions);
  const SessionDescription& last = read.sessions.back();
  EXPECT_EQ(last.number, one.number);
  EXPECT_EQ(last.session, one.session);
  EXPECT_EQ(last.client, one.client);
  EXPECT_EQ(last.device, one.device);
  EXPECT_EQ(last.tool, one.tool);
  EXPECT_EQ(last.role, one.role);
  EXPECT_EQ(last.parameters, one.parameters);
  EXPECT_EQ(last.samples, one.samples);
  EXPECT_EQ(last.missed, one.missed);
  EXPECT_EQ(last.round_trip, one.round_trip);
  EXPECT_EQ(last.delivered, one.delivered);
  EXPECT_EQ(last.burned, one.burned);
  EXPECT_EQ(last.balance, one.balance);
  EXPECT_EQ(last.seconds, one.seconds);
  EXPECT_EQ(last.hand_damping, one.hand_damping);
  EXPECT_TRUE(last.times.heard());
  EXPECT_EQ(last.times.wakeups(), one.times.wakeups());
  EXPECT_EQ(last.times.round_trips(), one.times.round_trips());
  one.seconds = one.hand_damping = std::nullopt;
  one.times = {};
  one.round_trip = one.balance = std::nullopt;
  const auto unknown = round_trip(SessionDescriptions{{one}, false});
  EXPECT_EQ(unknown.sessions[0].round_trip, std::nullopt);
  EXPECT_EQ(unknown.sessions[0].balance, std::nullopt);
  EXPECT_EQ(unknown.sessions[0].seconds, std::nullopt);
  EXPECT_EQ(unknown.sessions[0].hand_damping, std::nullopt);
  EXPECT_FALSE(unknown.sessions[0].times.heard());
}

TEST(Control, ASceneDescriptionIsReadAsWritten) {
  const DescribeScene asked = round_trip(DescribeScene{"a", 7});
  EXPECT_EQ(asked.scene, "a");
  EXPECT_EQ(asked.from, 7u);
  SceneDescription one{3, 4, Vec3(0.0, 1.0, -2.0), 5000, {}};
  one.materials.assign(kMaxMaterials, {1.0, 2.0, 3.0, 4.0, 5.0});
  const SceneDescription read = round_trip(one);
  EXPECT_EQ(read.version, 3u);
  EXPECT_EQ(read.changes, 4u);
  EXPECT_EQ(read.gravity, one.gravity);
  EXPECT_EQ(read.objects, 5000u);
  ASSERT_EQ(read.materials.size(), kMaxMaterials);
  const Material& last = read.materials.back();
  EXPECT_EQ(last.stiffness, 1.0);
  EXPECT_EQ(last.damping, 2.0);
  EXPECT_EQ(last.static_friction, 3.0);
  EXPECT_EQ(last.dynamic_friction, 4.0);
  EXPECT_EQ(last.viscous_friction, 5.0);
  EXPECT_EQ(read.times.answers, std::nullopt);
  one.times.answers.emplace().record(15'000, 3);
  one.times.world_late.emplace().record(1'000'000'000, 2);
  const SceneDescription timed = round_trip(one);
  EXPECT_EQ(timed.times.answers, one.times.answers);
  EXPECT_EQ(timed.times.world_late, one.times.world_late);
  one.gravity.reset();
  EXPECT_EQ(round_trip(one).gravity, std::nullopt);
  one.materials.emplace_back();  // exceeds the limit by one
  EXPECT_FALSE(decode(body(encode(one))));
}

}  // namespace
}  // namespace feltwire::control
