// Tests changes of a running scene: their effect on a hand, their refusals, and equal results of
// equal changes.

#include "server/scene/apply_live_change.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "server/scene/scene_sessions.hpp"
#include "tests/core/moving.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::live_change_test {
namespace {

using namespace std::chrono_literals;
using control::RefusalCode;
using control::Refused;
using ::testing::HasSubstr;

constexpr std::uint64_t kId = 0x1234567800;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A scene with a hand. The stage keeps the scenes that changes make.
struct Stage {
  explicit Stage(Scene begin, const SessionParameters& parameters = {})
      : scene(std::make_shared<const Scene>(std::move(begin))), sessions(*scene, 2s, 2) {
    control::JoinRequest request = test::join_request(parameters);
    request.device.max_force = 1000.0;
    EXPECT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(request, kId, test::keys(kId), now)));
  }
  std::vector<std::uint8_t> datagram(const Vec3& place) {
    SampleBatch batch = test::hand_batch(++index);
    batch.samples[0].pose.position = place;
    now += 1ms;
    DatagramBuffer out;
    const Bytes answer = sessions.receive(encoder.samples(kId, index, batch), {}, now, out);
    return {answer.begin(), answer.end()};
  }
  Reply at(const Vec3& place) {
    Reply reply;
    EXPECT_EQ(decode(test::opened(datagram(place), test::Way::down), reply), DropReason::none);
    return reply;
  }
  std::string make(const LiveChange& change) {
    ChangeOutcome outcome = sessions.change(change, now);
    if (const auto* refused = std::get_if<Refused>(&outcome)) return refused->reason;
    auto& made = std::get<Changed>(outcome);
    if (made.scene != nullptr) scene = made.scene;
    return made.what;
  }
  RefusalCode refusal(const LiveChange& change) {
    return std::get<Refused>(sessions.change(change, now)).code;
  }

  std::shared_ptr<const Scene> scene;
  SceneSessions sessions;
  test::SealedEncoder encoder{test::Way::up};
  Nanoseconds now{0};
  std::uint64_t index = 0;
};

SessionParameters with_model() {
  SessionParameters parameters;
  parameters.local_model = true;
  return parameters;
}

Scene floor_of(const Material& material) {
  return Scene("room", {test::object("floor", Plane{}, material)});
}

constexpr double kDepth = 0.001;  // [m]
const Vec3 kBelow(0, 0, -kDepth);

TEST(LiveChange, AStiffnessIsFeltFromTheNextSampleOnAndToldToLocalModels) {
  Stage stage(floor_of({.stiffness = 500.0}), with_model());
  const Reply before = stage.at(kBelow);
  EXPECT_NEAR(before.command.elastic.z(), 500.0 * kDepth, 1e-12);
  EXPECT_EQ(stage.make(MaterialChange{.object = "floor", .stiffness = 2000.0}),
            "object 'floor': stiffness 500 -> 2000 [N/m]");
  const Reply after = stage.at(kBelow);
  EXPECT_NEAR(after.command.elastic.z(), 2000.0 * kDepth, 1e-12);
  ASSERT_EQ(after.model.count, 1);
  EXPECT_EQ(after.model.patches[0].material.stiffness, 2000.0);
  // The client must treat the surface as new, but continue the held force.
  EXPECT_EQ(after.reloads, before.reloads + 1);
  EXPECT_EQ(after.model.scene, before.model.scene);
  EXPECT_TRUE(after.model.patches[0].touching);
}

/// A sticking hand must keep its stick point. The force is then stretch times the new stiffness.
TEST(LiveChange, AStickPointStaysWhereItIs) {
  const Material rough{.stiffness = 1000.0, .static_friction = 1.0, .dynamic_friction = 1.0};
  Stage stage(floor_of(rough));
  constexpr double kStretch = 0.0004;
  stage.at(kBelow);
  EXPECT_NEAR(stage.at(kBelow + Vec3(kStretch, 0, 0)).command.frictional.x(), -1000.0 * kStretch,
              1e-9);
  stage.make(MaterialChange{.object = "floor", .stiffness = 500.0});
  EXPECT_NEAR(stage.at(kBelow + Vec3(kStretch, 0, 0)).command.frictional.x(), -500.0 * kStretch,
              1e-9);
}

/// A new stick point is at the tool's position. The change itself must make no force.
TEST(LiveChange, FrictionThatASurfaceGetsBeginsAtZero) {
  Stage stage(floor_of({.stiffness = 1000.0}), with_model());
  const Vec3 place(0.03, 0.02, -kDepth);
  stage.at({0.01, 0.0, -kDepth});
  const Reply before = stage.at(place);
  stage.make(MaterialChange{.object = "floor", .static_friction = 0.8, .dynamic_friction = 0.5});
  const Reply after = stage.at(place);
  EXPECT_EQ(after.command.frictional.norm(), 0.0);
  EXPECT_NE(after.model.scene, before.model.scene);  // The client has no stick point either.
  const Reply moved = stage.at(place + Vec3(1e-4, 0, 0));
  EXPECT_NEAR(moved.command.frictional.x(), -1000.0 * 1e-4, 1e-9);
}

TEST(LiveChange, DampingThatASurfaceGetsBeginsWithTheVelocityOfNow) {
  Stage stage(floor_of({.stiffness = 1000.0}));
  for (int n = 0; n < 5; ++n) stage.at({0.001 * n, 0.0, -kDepth});
  stage.make(MaterialChange{.object = "floor", .viscous_friction = 3.0});
  const Vec3 still(0.004, 0.0, -kDepth);
  EXPECT_EQ(stage.at(still).command.frictional.norm(), 0.0);
  // a velocity of 0.1 mm per millisecond
  EXPECT_NEAR(stage.at(still + Vec3(1e-4, 0, 0)).command.frictional.x(), -3.0 * 0.1, 1e-9);
}

struct Bad {
  LiveChange change;
  const char* says;
};

/// A refused change must name its field. The change must not affect any bit of an answer.
TEST(LiveChange, RefusesWhatCannotBeAndChangesNothing) {
  SessionParameters other;
  other.mode = "per_axis";
  const std::vector<Bad> all = {
      {MaterialChange{.object = "flor", .stiffness = 1.0}, "no object 'flor' in scene 'room'"},
      {MaterialChange{.object = "floor"}, "no field of its material is given"},
      {MaterialChange{.object = "floor", .stiffness = 0.0}, "stiffness: must be above zero"},
      {MaterialChange{.object = "floor", .stiffness = -1.0}, "stiffness"},
      {MaterialChange{.object = "floor", .stiffness = kNan}, "stiffness"},
      {MaterialChange{.object = "floor", .stiffness = 1e10}, "stiffness: must be at most 1e+09"},
      {MaterialChange{.object = "floor", .damping = -1.0}, "damping"},
      {MaterialChange{.object = "floor", .viscous_friction = 1e7}, "viscous_friction"},
      {MaterialChange{.object = "floor", .static_friction = 101.0}, "static_friction"},
      {MaterialChange{.object = "floor", .dynamic_friction = 0.7},
       "dynamic_friction: must not exceed static_friction = 0.6"},
      // A request has a wrong field and a valid field. Neither field may change.
      {MaterialChange{.object = "floor", .stiffness = 10.0, .damping = -1.0}, "damping"},
      {GravityChange{Vec3(0, 0, -1)}, "nothing moves in scene 'room'"},
      {ParameterChange{kId, other}, "its client takes no other law"},
      {ParameterChange{kId + 1, other}, "there is no session"},
  };
  Stage stage(test::room()), untouched(test::room());
  for (const Bad& bad : all) {
    EXPECT_THAT(stage.make(bad.change), HasSubstr(bad.says));
    const Vec3 place(0.0001 * static_cast<double>(stage.index), 0, -kDepth);
    EXPECT_EQ(stage.datagram(place), untouched.datagram(place)) << bad.says;
  }
  EXPECT_EQ(stage.refusal(ParameterChange{kId + 1, other}), RefusalCode::unknown_session);
  EXPECT_EQ(stage.refusal(GravityChange{}), RefusalCode::bad_parameters);
}

Scene falling_ball() {
  return test::moving({test::object("floor", Plane{}, {.stiffness = 1000}, {0, 0, -10}),
                       test::object("ball", Sphere{0.03}, {.stiffness = 1000}, {0, 0, 1})},
                      {-1, 0}, {test::body("ball", 0.2, {0, 0, 1})});
}

TEST(LiveChange, RefusesAGravityThatIsNone) {
  Stage stage(falling_ball());
  for (const double value : {kNan, std::numeric_limits<double>::infinity(), 1e9})
    EXPECT_THAT(stage.make(GravityChange{Vec3(0, value, 0)}), HasSubstr("gravity.y"));
  EXPECT_EQ(stage.sessions.gravity(), std::optional(Vec3(0, 0, -9.81)));
}

/// m dv = m g dt, from the step after the next. A reload must restore the gravity of the file.
TEST(LiveChange, GravityActsOnWhatMoves) {
  Stage stage(falling_ball());
  const Vec3 away(5, 0, 0), gravity(0, 1.5, -1.62);
  const auto gained = [&](int steps) {
    const Vec3 before = stage.sessions.world()->momentum();
    for (int n = 0; n < steps; ++n) stage.at(away);
    return Vec3(stage.sessions.world()->momentum() - before);
  };
  stage.at(away);
  EXPECT_NEAR(gained(10).z(), -0.2 * 9.81 * 0.010, 1e-9);
  EXPECT_EQ(stage.make(GravityChange{gravity}), "gravity (0, 0, -9.81) -> (0, 1.5, -1.62) [m/s^2]");
  stage.at(away);  // This sample was evaluated before the change.
  EXPECT_LT((gained(10) - 0.2 * 0.010 * gravity).norm(), 1e-9);
  EXPECT_EQ(stage.sessions.gravity(), std::optional(gravity));
  stage.sessions.enter(*stage.scene, stage.now);
  EXPECT_EQ(stage.sessions.gravity(), std::optional(Vec3(0, 0, -9.81)));
}

/// A moving body must continue from its position with its new stiffness.
TEST(LiveChange, AMaterialOfWhatMovesChangesNotWhereItIs) {
  Stage stage(test::moving({test::object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                           {test::body("ball", 0.2)}, test::kWeightless));
  const Vec3 hand(0.029, 0, 0);
  for (int n = 0; n < 10; ++n) stage.at(hand);
  const World& world = *stage.sessions.world();
  const Vec3 momentum = world.momentum(), place = world.objects()[0].pose.position;
  EXPECT_LT(momentum.x(), 0.0);
  stage.make(MaterialChange{.object = "ball", .stiffness = 3000.0});
  EXPECT_EQ(stage.sessions.world(), &world);
  EXPECT_EQ(world.objects()[0].pose.position, place);
  EXPECT_EQ(world.momentum(), momentum);
  const Reply felt = stage.at(hand);
  const double depth = 0.03 - (hand - world.objects()[0].pose.position).norm();
  EXPECT_GT(depth, 0.0005);
  EXPECT_NEAR(felt.command.elastic.x(), 3000.0 * depth, 1e-9);
}

/// This change must set the bound of a session that the server bounds.
TEST(LiveChange, TheBoundOfASessionThatTheServerBounds) {
  SessionParameters parameters;
  parameters.side = BoundingSide::server;
  Stage stage(floor_of({.stiffness = 500.0}), parameters);
  SessionParameters wanted = parameters;
  wanted.mode = "per_axis";
  EXPECT_EQ(stage.make(ParameterChange{kId, wanted}),
            "session 1 (tester): mode contact_frame -> per_axis");
  EXPECT_EQ(stage.sessions.find(kId)->parameters(), wanted);
  wanted.mode = "no_such";
  EXPECT_THAT(stage.make(ParameterChange{kId, wanted}), HasSubstr("no_such"));
  EXPECT_EQ(stage.sessions.find(kId)->parameters().mode, "per_axis");
}

/// Equal changes among equal samples must give equal bytes. Replays of recordings need this
/// property.
TEST(LiveChange, TheSameChangesHaveTheSameResultBitForBit) {
  const std::vector<LiveChange> changes = {
      MaterialChange{.object = "ball", .stiffness = 700.0, .damping = 1.0},
      GravityChange{Vec3(0.3, 0, 2)},
      MaterialChange{.object = "ball", .static_friction = 0.5, .dynamic_friction = 0.4},
      MaterialChange{.object = "floor", .stiffness = 5.0}};
  const auto play = [&] {
    Stage stage(falling_ball());
    std::vector<std::vector<std::uint8_t>> answers;
    for (int n = 0; n < 400; ++n) {
      if (n % 90 == 80) stage.make(changes[static_cast<std::size_t>(n / 90)]);
      const Vec3 ball = stage.sessions.world()->objects()[1].pose.position;
      answers.push_back(stage.datagram(ball + Vec3(0.001 * (n % 7), 0, 0.028)));
    }
    return answers;
  };
  EXPECT_EQ(play(), play());
}

/// Lists all sessions, a part at a time.
TEST(LiveChange, ListsAllSessionsInParts) {
  const Scene scene = test::room();
  constexpr std::uint64_t kSessions = control::kMaxDescriptions + 6;
  SceneSessions sessions(scene, 2s, kSessions);
  for (std::uint64_t n = 1; n <= kSessions; ++n)
    sessions.answer(test::join_request(), n << 8, test::keys(n << 8), 0s);
  const auto ask = [&](std::uint32_t after) {
    return std::get<control::SessionDescriptions>(
        sessions.answer(control::DescribeSessions{"room", after}, 0, {}, 0s));
  };
  const auto first = ask(0);
  EXPECT_EQ(first.sessions.size(), control::kMaxDescriptions);
  EXPECT_TRUE(first.more);
  const auto rest = ask(first.sessions.back().number);
  EXPECT_EQ(rest.sessions.size(), 6u);
  EXPECT_FALSE(rest.more);
  EXPECT_EQ(rest.sessions.back().session, kSessions << 8);
  EXPECT_EQ(rest.sessions.back().client, "tester");
  EXPECT_EQ(rest.sessions.back().device, "test arm");
}

}  // namespace
}  // namespace feltwire::live_change_test
