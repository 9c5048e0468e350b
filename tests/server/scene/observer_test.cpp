// Tests observers in SceneSessions with a simulated clock. The tests check the views, and that no
// observer affects a hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/scene/mechanism.hpp"
#include "tests/core/moving.hpp"
#include "tests/server/make.hpp"
#include "tests/server/sample_exchange.hpp"

namespace feltwire::observer_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kAnna = 1 << 8, kBert = 2 << 8, kEye = 3 << 8;

/// A scene with sessions that send samples on request.
struct Stage : test::SampleExchange {
  explicit Stage(const Scene& of, std::size_t slots = 8)
      : SampleExchange(of, slots, {.sample_rate = 1e6}) {}

  void join(std::uint64_t id, Role role, const SessionParameters& parameters = {},
            bool figures = false) {
    control::JoinRequest request = test::join_request(parameters);
    request.role = role;
    request.figures = figures;
    request.device.rotation_sensed = 3;
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(request, id, test::keys(id), now)));
  }
  /// Returns the payload of the answer, or nothing if the server withheld it.
  std::vector<std::uint8_t> send(std::uint64_t id, const Pose& pose, const Command& held = {}) {
    Sample sample;
    sample.pose = pose;
    sample.held = held;
    return SampleExchange::send(id, sample, true);
  }
  std::vector<std::uint8_t> send(std::uint64_t id, const Vec3& place, const Command& held = {}) {
    return send(id, Pose{place, Quaternion::Identity()}, held);
  }
  /// Returns the next view of an observer at `place`.
  SceneView look(std::uint64_t id = kEye, const Vec3& place = Vec3::Zero()) {
    now += 1ms;
    SceneView view;
    Reply reply;
    EXPECT_EQ(decode(send(id, place), reply, &view), DropReason::none);
    EXPECT_EQ(reply.command, Command{});
    EXPECT_TRUE(view.present);
    return view;
  }
};

Scene weightless_ball() {
  return test::moving({test::object("floor", Plane{}, {.stiffness = 500}, {0, 0, -1}),
                       test::object("ball", Sphere{0.03}, {.stiffness = 1000})},
                      {-1, 0}, {test::body("ball", 0.2)}, test::kWeightless);
}

TEST(Observer, SeesTheHandsWhereTheyAre) {
  Stage stage(test::room());
  stage.join(kAnna, Role::operator_);
  stage.join(kEye, Role::observer);
  stage.join(kBert, Role::admin);
  EXPECT_EQ(stage.look().hand_count, 0u);  // No hand has sent its position yet.
  const Quaternion turned(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  stage.send(kBert, Pose{{0.5, -0.25, 0.125}, turned},
             {.elastic = {0, 0, 2}, .frictional = {1, 0, 0}});
  SceneView view = stage.look();
  ASSERT_EQ(view.hand_count, 1u);
  EXPECT_EQ(view.hand[0].number, 3u);  // the third client that joined
  EXPECT_EQ(view.hand[0].pose.position, Vec3(0.5, -0.25, 0.125));
  EXPECT_LE(view.hand[0].pose.orientation.angularDistance(turned), 1e-6);
  EXPECT_EQ(view.hand[0].force, Vec3(1, 0, 2));

  stage.send(kAnna, Vec3(0.1, 0.2, 0.3));
  view = stage.look();
  ASSERT_EQ(view.hand_count, 2u);
  EXPECT_EQ(view.hand[0].number, 1u);
  EXPECT_LE((view.hand[0].pose.position - Vec3(0.1, 0.2, 0.3)).norm(), 1e-7);
  EXPECT_EQ(view.hand[1].number, 3u);
  EXPECT_EQ(view.hands_from, 0u);
  EXPECT_EQ(view.hands_end, SceneView::kLastHand);
  EXPECT_EQ(view.body_count, 0u);
  EXPECT_EQ(view.bodies_end, SceneView::kLastBody);

  stage.sessions.answer(control::LeaveRequest{kAnna}, 0, {}, stage.now);
  view = stage.look();
  ASSERT_EQ(view.hand_count, 1u);
  EXPECT_EQ(view.hand[0].number, 3u);
  stage.join(kAnna, Role::operator_);
  stage.index[kAnna] = 0;
  stage.send(kAnna, Vec3(0, 0, 0));
  EXPECT_EQ(stage.look().hand[1].number, 4u);  // The server must never reuse a number.
}

TEST(Observer, SeesWhatMoves) {
  Stage stage(weightless_ball());
  stage.join(kAnna, Role::operator_);
  stage.join(kEye, Role::observer);
  stage.look();
  for (int n = 0; n < 200; ++n) {
    stage.now += 1ms;
    stage.send(kAnna, Vec3(-0.029, 0.005, 0));
    if (n % 50 != 49) continue;
    const SceneView view = stage.look();
    const Object& ball = stage.sessions.world()->objects()[1];
    ASSERT_EQ(view.body_count, 1u);
    EXPECT_EQ(view.body[0].object, 1u);
    EXPECT_LE((view.body[0].pose.position - ball.pose.position).norm(), 1e-7);
    EXPECT_LE(view.body[0].pose.orientation.angularDistance(ball.pose.orientation), 1e-6);
    EXPECT_GT(view.body[0].pose.position.x(), n < 100 ? 1e-6 : 1e-3);
    EXPECT_EQ(view.hand_count, 1u);
  }
}

/// Hands and bodies that exceed a datagram must come in parts. Each round must show all of them.
TEST(Observer, IsShownAllInTurns) {
  constexpr std::uint32_t kHands = 50;
  constexpr int kBalls = 40;
  std::vector<Object> objects = {test::object("floor", Plane{}, {}, {0, 0, -9})};
  std::vector<int> body_of = {-1};
  std::vector<Body> bodies;
  for (int i = 0; i < kBalls; ++i) {
    const std::string name = "ball" + std::to_string(i);
    const Vec3 place(0.1 * i, 0, 0);
    objects.push_back(test::object(name.c_str(), Sphere{0.01}, {}, place));
    bodies.push_back(test::body(name.c_str(), 0.1, place));
    body_of.push_back(i);
  }
  for (const double period : {0.001, 0.05}) {  // The second observer has a low rate.
    Stage stage(test::moving(objects, body_of, bodies, test::kWeightless), kHands + 2);
    SessionParameters parameters;
    parameters.servo_period = period;
    stage.join(kEye, Role::observer, parameters);
    for (std::uint32_t i = 0; i < kHands; ++i) {
      stage.join((100 + i) << 8, Role::operator_);
      stage.send((100 + i) << 8, Vec3(0.01 * i, 0, 1));
    }
    std::map<std::uint32_t, int> hands;
    std::map<std::uint16_t, int> seen_bodies;
    std::size_t views = 0;
    constexpr int kRounds = 3;
    for (int rounds = 0; rounds < kRounds; ++views) {
      ASSERT_LT(views, 100u);
      const SceneView view = stage.look();
      EXPECT_LE(stage.length, period < 0.04 ? kMaxDatagram : 600u);
      for (const SeenHand& hand : view.hands()) {
        ++hands[hand.number];
        EXPECT_LE((hand.pose.position - Vec3(0.01 * (hand.number - 2), 0, 1)).norm(), 1e-7);
      }
      for (const SeenBody& body : view.bodies()) {
        ++seen_bodies[body.object];
        EXPECT_LE((body.pose.position - Vec3(0.1 * (body.object - 1), 0, 0)).norm(), 1e-6);
      }
      if (view.bodies_end == SceneView::kLastBody) ++rounds;
    }
    EXPECT_EQ(hands.size(), kHands);
    EXPECT_EQ(seen_bodies.size(), std::size_t{kBalls});
    for (const auto& [number, times] : hands) EXPECT_EQ(times, kRounds) << "hand " << number;
    for (const auto& [object, times] : seen_bodies) EXPECT_EQ(times, kRounds) << "body " << object;
    // The number of datagrams must be minimal, except at the change from hands to bodies.
    const std::size_t bytes = kHands * SceneView::kHandSize + kBalls * SceneView::kBodySize;
    EXPECT_LE(views, kRounds * (bytes / (view_room(period) - SceneView::kHandSize) + 1));
  }
}

/// The server's own page draws these figures.
TEST(Observer, IsShownTheFiguresThatItAskedFor) {
  Stage stage(weightless_ball());
  stage.join(kAnna, Role::operator_);
  stage.join(kBert, Role::operator_);
  stage.join(kEye, Role::observer, {}, true);
  constexpr std::uint64_t kOther = 4 << 8;
  stage.join(kOther, Role::observer);
  for (int n = 0; n < 20; ++n) {
    stage.now += 1ms;
    stage.send(kAnna, Vec3(0.2, 0, -1.0 - 1e-4 * n), {.elastic = {0, 0, 0.5}});
    stage.send(kBert, Vec3(0.4, 0, 0));
  }
  Picture picture;
  stage.look();
  stage.look();
  const SceneView view = stage.look();
  stage.sessions.draw(picture, stage.now);
  ASSERT_EQ(view.hand_count, 2u);
  ASSERT_EQ(picture.hands.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const PictureHand& hand = picture.hands[i];
    ASSERT_TRUE(view.hand[i].figures.has_value());
    const HandFigures& figures = *view.hand[i].figures;
    EXPECT_EQ(figures.states, hand.states);
    EXPECT_EQ(figures.samples, hand.samples);
    EXPECT_EQ(figures.missed, hand.missed);
    EXPECT_LE((figures.proxy - hand.proxy).norm(), 1e-6);
    EXPECT_LE((figures.elastic - hand.elastic).norm(), 1e-6);
    EXPECT_NEAR(figures.depth, hand.depth, 1e-9);
    EXPECT_NEAR(figures.delivered, hand.delivered, 1e-9);
    EXPECT_NEAR(figures.burned, hand.burned, 1e-9);
  }
  EXPECT_GT(view.hand[0].figures->elastic.z(), 0.5);
  EXPECT_EQ(view.hand[1].figures->states, bit(HandState::free_space));
  const SceneView other = stage.look(kOther);
  for (const SeenHand& hand : other.hands()) EXPECT_FALSE(hand.figures.has_value());
}

/// With figures, too, all hands must come in turns within the size of a datagram.
TEST(Observer, IsShownTheFiguresOfManyInTurns) {
  constexpr std::uint32_t kHands = 30;
  for (const double period : {0.001, 0.05}) {
    Stage stage(weightless_ball(), kHands + 1);
    SessionParameters parameters;
    parameters.servo_period = period;
    stage.join(kEye, Role::observer, parameters, true);
    for (std::uint32_t i = 0; i < kHands; ++i) {
      stage.join((100 + i) << 8, Role::operator_);
      stage.send((100 + i) << 8, Vec3(0.01 * i, 0, 1));
    }
    std::set<std::uint32_t> seen;
    std::size_t bodies = 0;
    for (int views = 0; views < 40; ++views) {
      const SceneView view = stage.look();
      EXPECT_LE(stage.length, period < 0.04 ? kMaxDatagram : 600u);
      for (const SeenHand& hand : view.hands())
        if (hand.figures) seen.insert(hand.number);
      bodies += view.body_count;
    }
    EXPECT_EQ(seen.size(), kHands);
    EXPECT_GT(bodies, 0u);
  }
}

/// Compares hands with and without observers. They must agree bitwise.
TEST(Observer, IsFeltByNobody) {
  Stage watched(weightless_ball()), alone(weightless_ball());
  for (Stage* stage : {&watched, &alone}) {
    stage->join(kAnna, Role::operator_);
    stage->join(kBert, Role::operator_);
  }
  watched.join(kEye, Role::observer);
  for (int n = 0; n < 300; ++n) {
    for (Stage* stage : {&watched, &alone}) stage->now += 1ms;
    watched.send(kEye, Vec3(0.02 * std::sin(0.1 * n), 0, 0.001 * (n % 7)), {.elastic = {0, 0, 9}});
    const Vec3 push(-0.029, 0.001 * (n % 5), 0);
    EXPECT_EQ(watched.send(kAnna, push), alone.send(kAnna, push));
    EXPECT_EQ(watched.send(kBert, Vec3(0, 0, -0.999 - 0.002 * (n % 2))),
              alone.send(kBert, Vec3(0, 0, -0.999 - 0.002 * (n % 2))));
    EXPECT_EQ(watched.length, alone.length);
  }
  EXPECT_NE(alone.sessions.world()->momentum(), Vec3::Zero());
  EXPECT_EQ(watched.sessions.world()->momentum(), alone.sessions.world()->momentum());
}

TEST(Observer, ClaimsOfOthersCannotSpoilItsReplies) {
  constexpr double kHuge = std::numeric_limits<float>::max();
  Stage stage(test::room());
  stage.join(kAnna, Role::operator_);
  stage.join(kEye, Role::observer);
  stage.send(kAnna, Vec3(1000, -1000, 1000),
             {.elastic = {kHuge, -kHuge, 1}, .frictional = {kHuge, -kHuge, 2}});
  const SceneView view = stage.look();
  ASSERT_EQ(view.hand_count, 1u);
  EXPECT_NEAR(view.hand[0].force.x(), 1e12, 1e6);
  EXPECT_NEAR(view.hand[0].force.y(), -1e12, 1e6);
  EXPECT_EQ(view.hand[0].force.z(), 3.0);
  EXPECT_EQ(view.hand[0].pose.position, Vec3(1000, -1000, 1000));
}

TEST(Observer, IsAnsweredAsOftenAsItAsked) {
  Stage stage(test::room());
  SessionParameters sparing;
  sparing.force_deadband = 0.1;
  stage.join(kEye, Role::observer, sparing);
  int answers = 0;
  for (int n = 0; n < 200; ++n) {
    stage.now += 1ms;
    answers += stage.send(kEye, Vec3::Zero()).empty() ? 0 : 1;
  }
  EXPECT_NEAR(answers, 10, 1);  // one answer per keep_alive, because no force changes
}

TEST(Observer, SeesTheSceneThatWasReloaded) {
  const Scene still = test::room(), moving = weightless_ball();
  Stage stage(moving);
  stage.join(kEye, Role::observer);
  EXPECT_EQ(stage.look().body_count, 1u);
  stage.sessions.enter(still, stage.now);
  const SceneView after = stage.look();
  EXPECT_EQ(after.body_count, 0u);
  EXPECT_EQ(after.bodies_from, 0u);
  EXPECT_EQ(after.bodies_end, SceneView::kLastBody);  // No body may be left.
  stage.sessions.enter(moving, stage.now);
  EXPECT_EQ(stage.look().body_count, 1u);
}

/// An observer's token must not lead a robot, for any content of its samples.
TEST(Observer, LeadsNoRobot) {
  Scene scene = test::room();
  scene.set_seats({RemoteSeat{}});
  for (const Role role : {Role::observer, Role::pointer, Role::operator_}) {
    Stage stage(scene);
    stage.lead = Lead{};  // The switch is released. An operator would be ready.
    stage.join(kAnna, role);
    stage.join(kEye, Role::observer);
    stage.join(kBert, Role::follower);
    Encoder payload;
    DatagramBuffer out;
    RobotState state;
    state.index = 1;
    stage.sessions.receive(
        stage.encoder.seal({DatagramKind::follower_state, kBert, 1}, payload.state(state)),
        stage.peer, stage.now, out);
    Reply reply;
    ASSERT_EQ(decode(stage.send(kAnna, Vec3::Zero()), reply), DropReason::none);
    EXPECT_EQ(reply.remote.has_value(), role == Role::operator_);
    EXPECT_EQ(stage.sessions.link_state(0) == LinkState::disabled, role != Role::operator_);
    EXPECT_TRUE(stage.look().present);  // The datagram has room for the view.
  }
}

TEST(Observer, TakesNoMemoryOnTheWay) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate";
#endif
  Stage stage(weightless_ball(), 60);
  stage.join(kEye, Role::observer);
  for (std::uint64_t i = 0; i < 50; ++i) stage.join((100 + i) << 8, Role::operator_);
  for (std::uint64_t i = 0; i < 50; ++i) stage.send((100 + i) << 8, Vec3(0, 0, 0.1));
  stage.look();
  stage.allocated = 0;
  for (int n = 0; n < 50; ++n) stage.look();
  EXPECT_EQ(stage.allocated, 0u);
}

}  // namespace
}  // namespace feltwire::observer_test
