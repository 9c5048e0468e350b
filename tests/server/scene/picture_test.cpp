// Tests pictures of a scene: the positions of hands and proxies, the data of each hand, and the
// exchange between the threads of scene and viewer.

#include "server/picture/picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/scene/mechanism.hpp"
#include "tests/core/moving.hpp"
#include "tests/server/make.hpp"
#include "tests/server/sample_exchange.hpp"

namespace feltwire::picture_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kAnna = 1 << 8, kEye = 2 << 8;

struct Stage : test::SampleExchange {
  using SampleExchange::SampleExchange;
  void join(std::uint64_t id, Role role = Role::operator_,
            const SessionParameters& parameters = {}) {
    control::JoinRequest request = test::join_request(parameters);
    request.role = role;
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(request, id, test::keys(id), now)));
  }
  void put(const Vec3& place, const Vec3& held = Vec3::Zero()) {
    now += 1ms;
    Sample sample;
    sample.pose.position = place;
    sample.held.elastic = held;
    send(kAnna, sample, false);
  }
  PictureHand hand() {
    sessions.draw(picture, now);
    EXPECT_EQ(picture.hands.size(), 1u);
    return picture.hands.at(0);
  }
  Picture picture;
};

bool says(const PictureHand& hand, HandState state) { return (hand.states & bit(state)) != 0; }

/// The scene has a floor of 2000 N/m at z = 0.
TEST(Picture, ShowsTheProxyAndWhatTheSceneAsksFor) {
  Stage stage(test::room(0.0));
  stage.join(kEye, Role::observer);
  stage.join(kAnna);
  EXPECT_EQ(stage.hand().states, bit(HandState::waiting));

  stage.put({-0.05, 0, 0.01});
  PictureHand hand = stage.hand();
  EXPECT_EQ(hand.number, 2u);
  EXPECT_EQ(hand.states, bit(HandState::free_space));
  EXPECT_EQ(hand.proxy, hand.pose.position);
  EXPECT_EQ(hand.depth, 0.0);

  stage.put({-0.05, 0, -0.001}, {0, 0, 2.0});
  hand = stage.hand();
  EXPECT_EQ(hand.states, bit(HandState::touching));
  EXPECT_NEAR((hand.proxy - Vec3(-0.05, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(hand.depth, 0.001, 1e-12);
  EXPECT_NEAR((hand.elastic - Vec3(0, 0, 2.0)).norm(), 0.0, 1e-9);
  EXPECT_EQ(hand.held, Vec3(0, 0, 2.0));
  EXPECT_EQ(hand.samples, 2u);

  // The hand moved out by 1 mm under 2 N.
  stage.put({-0.05, 0, 0});
  hand = stage.hand();
  EXPECT_NEAR(hand.delivered, 0.002, 1e-9);
  EXPECT_GT(hand.burned, 0.0);
}

/// A picture contains the client's surfaces only if the client renders a local model.
TEST(Picture, HasTheSurfacesOfALocalModel) {
  SessionParameters parameters;
  for (const bool modelled : {true, false}) {
    parameters.local_model = modelled;
    Stage stage(test::room(0.0));
    stage.join(kAnna, Role::operator_, parameters);
    EXPECT_EQ(stage.hand().surfaces.count, 0);  // before the first sample of the hand
    stage.put({-0.05, 0, 0.001});
    const LocalModel surfaces = stage.hand().surfaces;
    const auto floor =
        std::ranges::find(surfaces.view(), Vec3(Vec3::UnitZ()), &SurfacePatch::normal);
    ASSERT_EQ(floor != surfaces.view().end(), modelled);
    if (!modelled) continue;
    EXPECT_NEAR((floor->point - Vec3(-0.05, 0, 0)).norm(), 0.0, 1e-12);
    EXPECT_GT(surfaces.reach, 0.0);
  }
}

/// The hand is in the ball and the floor at once. The proxy must be outside of both.
TEST(Picture, AddsTheSurfacesThatAreTouched) {
  Stage stage(test::room(0.0));
  stage.join(kAnna);
  stage.put({0.03 - 0.001, 0, 0.01});
  stage.put({0.03 + 0.002, 0, 0.01});
  const PictureHand hand = stage.hand();
  EXPECT_NEAR(hand.depth, 0.002, 1e-12);
  EXPECT_NEAR((hand.proxy - Vec3(0.03, 0, 0.01)).norm(), 0.0, 1e-12);
}

TEST(Picture, SaysWhyLittleIsFelt) {
  Stage stage(test::room(0.0));
  stage.join(kAnna, Role::operator_, test::server_bounds());
  stage.put({-0.05, 0, 0.001});
  stage.put({-0.05, 0, -0.02}, Vec3::Zero());  // The scene commands 40 N, but the device has 20 N.
  PictureHand hand = stage.hand();
  EXPECT_TRUE(says(hand, HandState::touching));
  EXPECT_TRUE(says(hand, HandState::server_bound));
  EXPECT_TRUE(says(hand, HandState::saturated));
  EXPECT_TRUE(says(hand, HandState::client_less));
  EXPECT_FALSE(says(hand, HandState::silent));
  stage.now += 150ms;  // The hold_time is 100 ms.
  EXPECT_TRUE(says(stage.hand(), HandState::silent));
}

TEST(Picture, ShowsWhatMoves) {
  const Scene scene = test::moving({test::object("floor", Plane{}, {.stiffness = 500}, {0, 0, -1}),
                                    test::object("ball", Sphere{0.03}, {.stiffness = 1000})},
                                   {-1, 0}, {test::body("ball", 0.2)}, test::kWeightless);
  Stage stage(scene);
  stage.join(kAnna);
  stage.put({0, 0, -0.028});  // The hand pushes the body up.
  for (int i = 0; i < 100; ++i) stage.put({0, 0, -0.028});
  stage.hand();
  ASSERT_EQ(stage.picture.bodies.size(), 1u);
  EXPECT_EQ(stage.picture.bodies[0].object, 1u);
  EXPECT_EQ(stage.picture.bodies[0].pose.position,
            stage.sessions.world()->objects()[1].pose.position);
  EXPECT_GT(stage.picture.bodies[0].pose.position.z(), 1e-6);
}

TEST(Picture, DescribesHandsAndNoObservers) {
  Stage stage(test::room());
  stage.join(kEye, Role::observer);
  stage.now += 250ms;
  stage.join(kAnna);
  const auto hands = stage.sessions.describe();
  ASSERT_EQ(hands.size(), 1u);
  EXPECT_EQ(hands[0].number, 2u);
  EXPECT_EQ(hands[0].session, kAnna);
  EXPECT_EQ(hands[0].client, "tester");
  EXPECT_EQ(hands[0].device, "test arm");
  EXPECT_EQ(hands[0].joined, stage.now);
}

/// A picture must not allocate if an earlier picture had as many hands and bodies.
TEST(Picture, ASecondPictureAllocatesNothing) {
  Stage stage(test::room());
  stage.join(kAnna);
  stage.put({0, 0, -0.001});
  stage.hand();
  const std::size_t before = test::allocations();
  stage.sessions.draw(stage.picture, stage.now);
  EXPECT_EQ(test::allocations(), before);
}

TEST(PictureExchange, AsksThenGives) {
  PictureExchange exchange;
  Picture seen;
  EXPECT_FALSE(exchange.wanted());
  EXPECT_FALSE(exchange.take(seen));  // The call requests a picture.
  EXPECT_TRUE(exchange.wanted());
  EXPECT_FALSE(exchange.take(seen));  // no picture yet
  exchange.picture().version = 5;
  exchange.give();
  EXPECT_FALSE(exchange.wanted());
  EXPECT_TRUE(exchange.take(seen));
  EXPECT_EQ(seen.version, 5u);
  EXPECT_TRUE(exchange.wanted());
}

/// Each picture must be complete.
TEST(PictureExchange, BetweenThreads) {
  constexpr std::uint32_t kPictures = 2000;
  PictureExchange exchange;
  std::thread scene([&] {
    for (std::uint32_t n = 1; n <= kPictures;) {
      if (!exchange.wanted()) {
        std::this_thread::yield();
        continue;
      }
      Picture& picture = exchange.picture();
      picture.version = n;
      picture.bodies.assign(n % 50, {n, {}});
      exchange.give();
      ++n;
    }
  });
  Picture seen;
  while (seen.version < kPictures) {
    const std::uint32_t before = seen.version;
    if (!exchange.take(seen)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(seen.version, before + 1);
    ASSERT_EQ(seen.bodies.size(), seen.version % 50);
    for (const PictureBody& body : seen.bodies) ASSERT_EQ(body.object, seen.version);
  }
  scene.join();
}

}  // namespace
}  // namespace feltwire::picture_test
