// The bounding method changes under a hand. The held force must fade, no force may step up, and the
// port must stay passive.

#include <gtest/gtest.h>

#include <array>
#include <deque>

#include "server/scene/session.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::law_change_test {
namespace {

using namespace testing::servo;
using test::Random;

constexpr double kTick = 1e-3;  // [s]
constexpr std::array kBounded = {"contact_frame", "shaped", "midpoint", "credited", "energy_tank"};

SessionParameters with_model(std::string_view mode) {
  SessionParameters p = parameters(mode);
  p.local_model = true;
  return p;
}

Scene floor(double stiffness) {
  Object plane;
  plane.name = "floor";
  plane.shape = Plane{};
  plane.material = {.stiffness = stiffness, .static_friction = 0.4, .dynamic_friction = 0.3};
  return Scene("floor", {plane});
}

/// A hand on a floor and its server.
struct Hand {
  explicit Hand(const SessionParameters& p, const ServoOptions& options = {})
      : parameters(p),
        servo_options(options),
        bench(p, options),
        session({"tester", "floor", bench.spec, p}, scene.views().front()) {}
  /// Returns the force on the hand at this height [m].
  double at_height(double z) {
    const Command given = bench.tick(at(0.0, 0.0, z));
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = bench.servo.sample();
    bench.servo.take(session.take(batch, bench.now).reply, bench.now);
    return given.force().norm();
  }
  /// Moves down slowly to a depth and stays there. Returns the last force.
  double press(double depth, int ticks = 400) {
    double force = 0.0;
    for (int n = 1; n <= ticks; ++n)
      force = at_height(0.002 - (0.002 + depth) * std::min(1.0, n / (0.75 * ticks)));
    return force;
  }
  ServoLaw& change_to(const SessionParameters& p) {
    parameters = p;
    laws.emplace_back(bench.spec, p, servo_options);
    bench.servo.adopt(laws.back());
    return laws.back();
  }
  void change_to(std::string_view mode) {
    SessionParameters p = parameters;
    p.mode = mode;
    change_to(p);
  }

  SessionParameters parameters;
  ServoOptions servo_options;
  Scene scene = floor(800.0);
  Bench bench;
  Session session;
  std::deque<ServoLaw> laws;
};

/// Each ordered pair of the methods is tested. A protected hand rests in the floor.
TEST(LawChange, FadesThenWaitsAndTheAccountGoesOn) {
  for (const char* before : kBounded)
    for (const char* after : kBounded) {
      if (std::string_view(before) == after) continue;
      SCOPED_TRACE(std::string(before) + " -> " + after);
      Hand hand(with_model(before), protect_hand(with_model(before)));
      double force = hand.press(0.002);
      ASSERT_GT(force, 0.3);
      const double fade = hand.bench.spec.max_force / (0.5 * hand.parameters.hold_time) * kTick;
      hand.change_to(after);
      EXPECT_TRUE(hand.bench.servo.changes_law());
      EXPECT_EQ(hand.bench.servo.parameters().mode, before);
      int ticks = 0;
      for (; hand.bench.servo.changes_law() && ticks < 1000; ++ticks) {
        const double next = hand.at_height(-0.002);
        EXPECT_LE(next, force + 1e-9);                // The force never rises.
        EXPECT_GE(next, force - 1.01 * fade - 1e-9);  // The force falls no faster than a fade.
        force = next;
      }
      EXPECT_LE(ticks, 52);  // Half the hold time and the ticks at both ends
      EXPECT_EQ(force, 0.0);
      EXPECT_EQ(hand.bench.servo.parameters().mode, after);
      EXPECT_GT(hand.bench.servo.account()->balance(), 0.0);
      EXPECT_LE(hand.bench.servo.account()->balance(), hand.bench.servo.port().margin() + 1e-12);
      // The account now covers a force. The servo must still not push the hand out.
      for (int n = 0; n < 100; ++n) EXPECT_LE(hand.at_height(-0.002), 0.05);
      // After leaving and entering the floor again, the hand must feel the floor.
      for (int n = 0; n < 100; ++n) hand.at_height(-0.002 + 4e-5 * n);
      EXPECT_GT(hand.press(0.002), 0.3);
      EXPECT_EQ(hand.bench.servo.port().violations(), 0u);
    }
}

/// The methods change at random under a random hand. No force may step up beyond the limits of the
/// methods. The hand never gets more energy than the device dissipated.
TEST(LawChange, BringsNoEnergyWhateverTheHandDoes) {
  int changes = 0;
  for (const std::uint64_t seed : test::seeds(1, 40, 20)) {
    Random random(seed);
    const auto any = [&] { return kBounded[static_cast<std::size_t>(random.uniform(0.0, 4.999))]; };
    Hand hand(with_model(any()));
    double z = 0.004, goal = 0.0, speed = 0.0;
    int since = 0;  // the tick before a fade began
    for (int n = 0; n < 3000; ++n) {
      if (random.chance(0.02)) {
        goal = random.uniform(-0.004, 0.002);
        speed = random.uniform(0.0, 2e-4);
      }
      z += std::clamp(goal - z, -speed, speed);
      const bool waits = hand.bench.servo.changes_law();
      const double force = hand.at_height(z);
      if (waits) {
        // While the change fades, the force may reach a part of the floor's command. The method
        // evaluates this command half a tick ahead of a moving hand. For a resting hand, the method
        // evaluates the command between two encoder readings.
        const double left = std::max(0.0, 1.0 - (n - since) / 50.0);
        const double quantum = hand.bench.spec.position_resolution;
        const double most = 800.0 * (std::max(0.0, -z) + 2.0 * speed + 1.5 * quantum) * left;
        ASSERT_LE(force, hand.bench.servo.changes_law() ? most + 1e-9 : 0.0)
            << "seed " << seed << " tick " << n;
      }
      ASSERT_EQ(hand.bench.servo.port().violations(), 0u) << "seed " << seed << " tick " << n;
      ASSERT_GE(hand.bench.servo.account()->balance(), -1e-12) << "seed " << seed << " tick " << n;
      if (random.chance(0.01)) {
        if (!hand.bench.servo.changes_law()) since = n;
        hand.change_to(any());
        ++changes;
      }
    }
  }
  EXPECT_GT(changes, test::rounds(300));
}

/// Without a bound the complete force would step up. A protected hand must therefore leave the
/// floor first.
TEST(LawChange, ToNoBoundWaitsForASmallForce) {
  Hand hand(with_model("shaped"), protect_hand(with_model("shaped")));
  hand.press(0.002);
  hand.change_to("none");
  while (hand.bench.servo.changes_law()) hand.at_height(-0.002);
  for (int n = 0; n < 200; ++n) EXPECT_LE(hand.at_height(-0.002), 0.05);
  hand.at_height(0.001);
  hand.at_height(0.001);
  EXPECT_FALSE(hand.bench.servo.account());
  EXPECT_NEAR(hand.press(0.002), 800.0 * 0.002, 0.01);
}

TEST(LawChange, TakesNoMemoryInTheServo) {
  Hand hand(with_model("shaped"));
  hand.press(0.002);
  hand.laws.emplace_back(hand.bench.spec, with_model("contact_frame"), ServoOptions{});
  std::size_t allocated = test::allocations();
  hand.bench.servo.adopt(hand.laws.back());
  for (int n = 0; n < 60; ++n) hand.bench.tick(at(0.0, 0.0, -0.002));
  allocated = test::allocations() - allocated;
  EXPECT_EQ(allocated, 0u);
  EXPECT_FALSE(hand.bench.servo.changes_law());
}

/// The client reports the change. The change continues after a lost session.
TEST(LawChange, IsToldAndOutlivesALostSession) {
  Hand hand(with_model("shaped"));
  hand.press(0.002);
  hand.change_to("contact_frame");
  hand.at_height(-0.002);
  EXPECT_NE(hand.bench.servo.report().reasons & bit(HandReason::law_change), 0u);
  EXPECT_EQ(hand.bench.servo.report().reasons & bit(HandReason::reconnecting), 0u);
  hand.bench.servo.reconnected(false);
  int ticks = 0;
  for (; hand.bench.servo.changes_law() && ticks < 1000; ++ticks) hand.at_height(-0.002);
  EXPECT_LE(ticks, 52);
  EXPECT_EQ(hand.bench.servo.parameters().mode, "contact_frame");
  EXPECT_EQ(hand.bench.servo.report().reasons & bit(HandReason::law_change), 0u);
}

}  // namespace
}  // namespace feltwire::law_change_test
