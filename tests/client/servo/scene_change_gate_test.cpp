// A scene changes while a hand presses. Tests the resulting force.

#include "client/servo/scene_change_gate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "server/scene/session.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::scene_change_gate_test {
namespace {

using namespace testing::servo;

constexpr double kDepth = 5e-3;  // [m]

Scene wall(double stiffness) {
  Object object;
  object.name = "wall";
  object.shape = Plane{};
  object.material.stiffness = stiffness;
  return Scene("wall", {object});
}

/// A hand and a session without a network. The test sets the hand's position.
struct Hand {
  Bench bench;
  Session session;
  double slowest = 1e300, fastest = 0.0;  // [N/s] smallest and largest rate of the force
  double force = 0.0;                     // [N]

  Hand(const SessionParameters& p, const Scene& scene)
      : bench(p), session({"tester", "wall", bench.spec, p}, scene) {}

  void tick(double depth) {
    const double before = force;
    force = bench.tick(surely_at(0, 0, -depth)).force().z();
    fastest = std::max(fastest, (force - before) / 1e-3);
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = bench.servo.sample();
    bench.servo.take(session.take(batch, bench.now).reply, bench.now);
  }
  void press(double to, int ticks = 500) {
    for (int i = 1; i <= ticks; ++i) tick(to * i / ticks);
  }
  void rest(double depth, int ticks = 1000) {
    for (int i = 0; i < ticks; ++i) tick(depth);
  }
  const PortEnergy& port() const { return bench.servo.port(); }
};

/// The displayed stiffness k' rises to the geometric mean of the old stiffness k and the bound's
/// stiffness c = 2 b / T. The work k d^2 / 2 of the hand in the old wall covers the stored energy
/// (k' d)^2 / (2 c).
TEST(SceneChangeGate, AHandThatRestsFeelsAStifferWallAsFarAsItsOwnWorkPays) {
  const Scene soft = wall(100.0), stiff = wall(900.0), middle = wall(250.0);
  for (const Storage storage : {Storage::minimal, Storage::elastic}) {
    SessionParameters p = parameters("contact_frame");
    p.storage = storage;
    const double c = 2.0 * builtin_device("simulated").damping.least() / p.servo_period;
    Hand hand(p, soft);
    hand.press(kDepth);
    hand.rest(kDepth);
    // The force is a tick late. A resting hand gets no larger force.
    ASSERT_NEAR(hand.force, 100.0 * kDepth, 2e-3);
    EXPECT_FALSE(hand.bench.servo.withholds_change());

    hand.session.enter(Session::Place(middle, nullptr));
    hand.fastest = 0.0;
    hand.rest(kDepth);
    EXPECT_NEAR(hand.force, 250.0 * kDepth, 1e-6);  // 250 < sqrt(100 c) = 316
    EXPECT_FALSE(hand.bench.servo.withholds_change());
    // With minimal storage the force rises no faster than a fade falls. With elastic storage the
    // force rises at once.
    if (storage == Storage::minimal) {
      EXPECT_LE(hand.fastest, 1.001 * hand.bench.spec.max_force / (0.5 * p.hold_time));
    }
    EXPECT_GT(hand.fastest, 0.0);

    hand.session.enter(Session::Place(stiff, nullptr));
    hand.rest(kDepth);
    EXPECT_NEAR(hand.force, std::sqrt(100.0 * c) * kDepth, 0.02 * std::sqrt(100.0 * c) * kDepth);
    EXPECT_TRUE(hand.bench.servo.withholds_change());
    EXPECT_EQ(hand.port().violations(), 0u);

    // After a release and a new touch, the hand feels the complete stiffness.
    hand.rest(-1e-3, 10);
    EXPECT_FALSE(hand.bench.servo.withholds_change());
    hand.press(kDepth);
    EXPECT_NEAR(hand.force, 900.0 * kDepth, 1e-2);
    EXPECT_EQ(hand.port().violations(), 0u);
  }
}

TEST(SceneChangeGate, ASofterWallIsFeltAtOnce) {
  const Scene stiff = wall(900.0), soft = wall(100.0);
  Hand hand(parameters("contact_frame"), stiff);
  hand.press(kDepth);
  hand.session.enter(Session::Place(soft, nullptr));
  hand.rest(kDepth, 3);
  EXPECT_NEAR(hand.force, 100.0 * kDepth, 1e-6);
  EXPECT_FALSE(hand.bench.servo.withholds_change());
}

/// Energy that the device dissipated earlier in free space must not count.
TEST(SceneChangeGate, AHandThatASceneClosesRoundIsNotFlungOut) {
  const Scene nothing = wall(1e-3), stiff = wall(900.0);
  Hand hand(parameters("contact_frame"), nothing);
  // Each iteration dissipates 0.07 J.
  for (int i = 0; i < 200; ++i) hand.tick(i % 2 == 0 ? -0.02 : -0.001);
  hand.press(kDepth);
  ASSERT_GT(hand.port().margin(), 1.0);
  hand.session.enter(Session::Place(stiff, nullptr));
  hand.rest(kDepth);
  EXPECT_LE(hand.force, 1.01 * std::sqrt(1e-3 * 1000.0) * kDepth);
  EXPECT_TRUE(hand.bench.servo.withholds_change());
}

TEST(SceneChangeGate, OnlyTheContactFrameOfThisSideThatCreditsTheDeviceAloneHasIt) {
  const Scene soft = wall(100.0), stiff = wall(900.0);
  SessionParameters credited = parameters("contact_frame");
  credited.operator_damping = 0.1;
  for (const SessionParameters& p : {parameters("energy_tank"), parameters("per_axis"), credited,
                                     parameters("contact_frame", BoundingSide::server)}) {
    Hand hand(p, soft);
    hand.press(kDepth);
    hand.session.enter(Session::Place(stiff, nullptr));
    hand.rest(kDepth, 100);
    EXPECT_FALSE(hand.bench.servo.withholds_change());
  }
}

}  // namespace
}  // namespace feltwire::scene_change_gate_test
