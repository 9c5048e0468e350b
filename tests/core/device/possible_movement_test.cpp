// Tests which movements between readings are possible for a hand.

#include "core/device/possible_movement.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

namespace feltwire::possible_movement_test {
namespace {

constexpr double kPeriods[] = {1e-5, 1e-4, 2.5e-4, 1e-3, 2e-3, 0.01, 0.1};  // [s]
constexpr double kJust = 1e-9;

MovementBounds bounds() { return position_bounds(builtin_device("simulated")); }
/// Returns the largest possible movement [m] of a tick, after a tick at the speed `before` [m/s] in
/// this direction.
double farthest(const MovementBounds& b, double time, double before = 0.0) {
  return std::min(b.fastest, before + b.knock + b.pull * time) * time + 2.0 * b.error;
}

TEST(PossibleMovement, JustWithinTheLimitIsAHandAndJustBeyondIsNoneAtEveryRate) {
  for (const DeviceSpec& spec : builtin_devices()) {
    for (const MovementBounds& b : {position_bounds(spec), rotation_bounds(spec)}) {
      for (const double T : kPeriods) {
        const Vec3 way = farthest(b, T) * Vec3(0.6, 0.0, -0.8);
        EXPECT_TRUE(PossibleMovement(b).made((1.0 - kJust) * way, T)) << spec.name << " " << T;
        EXPECT_FALSE(PossibleMovement(b).made((1.0 + kJust) * way, T)) << spec.name << " " << T;
      }
    }
  }
}

TEST(PossibleMovement, AHandThatMovesAlreadyMayGoFarther) {
  const MovementBounds b = bounds();
  for (const double T : kPeriods) {
    const double v = 1.5;
    for (const double over : {-kJust, kJust}) {
      PossibleMovement moves(b);
      ASSERT_TRUE(moves.made(Vec3(v * T, 0, 0), T));
      EXPECT_EQ(moves.made(Vec3((1.0 + over) * farthest(b, T, v), 0, 0), T), over < 0.0) << T;
    }
  }
}

TEST(PossibleMovement, AHandMayBeStoppedAndThrownBackAtOnce) {
  for (const double T : kPeriods) {
    PossibleMovement moves(bounds());
    for (double v = 0.0; v < 6.0; v += 0.25)  // A strong hand accelerates.
      ASSERT_TRUE(moves.made(Vec3(v * T, 0, 0), T)) << v;
    PossibleMovement thrown_back = moves;
    EXPECT_TRUE(thrown_back.made(Vec3(-3.0 * T, 2.0 * T, 0), T)) << T;
    EXPECT_TRUE(moves.made(Vec3::Zero(), T)) << T;
    EXPECT_TRUE(moves.made(Vec3(-1.9 * T, 0, 0), T)) << T;
  }
}

/// An encoder bit flickers. The first steps may be an impact, but later steps exceed the limits of
/// a hand.
TEST(PossibleMovement, AFlickerIsNoHandAfterAFewTicks) {
  const MovementBounds b = bounds();
  for (const double T : kPeriods) {
    if (b.pull * T >= b.knock) continue;  // At such a slow rate a hand may move this far.
    const double d = 0.9 * farthest(b, T);
    PossibleMovement moves(b);
    double earned = 0.0;  // [J] dissipated energy at 0.5 N s/m
    int n = 0;
    for (; n < 20 && moves.made(Vec3(n % 2 == 0 ? d : -d, 0, 0), T); ++n) earned += 0.5 * d * d / T;
    EXPECT_LE(n, 6) << T;
    EXPECT_LE(earned, 0.04) << T;
  }
}

TEST(PossibleMovement, AfterAJumpItBeginsAtRest) {
  PossibleMovement moves(bounds());
  for (double v = 0.0; v < 6.0; v += 0.25) ASSERT_TRUE(moves.made(Vec3(v * 1e-3, 0, 0), 1e-3));
  EXPECT_FALSE(moves.made(Vec3(0.02, 0, 0), 1e-3));
  EXPECT_FALSE(moves.made(Vec3(6e-3, 0, 0), 1e-3));
  EXPECT_TRUE(moves.made(Vec3(2e-3, 0, 0), 1e-3));
}

TEST(PossibleMovement, NumbersThatAreNoneAreNoMovement) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300})
    EXPECT_FALSE(PossibleMovement(bounds()).made(Vec3(0, bad, 0), 1e-3));
}

/// Hands shake, strike, stop and arrive late, with encoder steps. No movement may count as a jump.
/// 5 m/s and 250 m/s^2 exceed human movements at a desk.
TEST(PossibleMovement, FastHonestHandsAreNoJump) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  const double q = builtin_device("simulated").position_resolution;
  for (const double T : {1e-4, 2.5e-4, 1e-3, 2e-3, 0.01, 0.1}) {
    for (const auto& swings : {std::pair{0.1, 5.0}, {0.05, 3.0}, {0.002, 0.7}}) {
      const double amplitude = swings.first, peak = swings.second;
      const bool meets_a_stop = peak <= 3.0;
      PossibleMovement moves(bounds());
      const double w = peak / amplitude;
      double t = 0.0;
      const auto place = [&](double at) {
        // A stop reverses the speed of the hand.
        const double swing = amplitude * std::cos(w * at) + 0.5 * amplitude;
        const double z = meets_a_stop ? std::abs(swing) : swing;
        const double y = 0.5 * amplitude * std::sin(0.7 * w * at);
        return Vec3(0.0, q * std::round(y / q), q * std::round(z / q));
      };
      Vec3 before = place(0.0);
      for (int n = 0; n < 20000; ++n) {
        // Some ticks are late, even by several periods.
        const double elapsed = any(random) < 0.02 ? T * (1.0 + 8.0 * any(random)) : T;
        t += elapsed;
        const Vec3 now = place(t);
        ASSERT_TRUE(moves.made(now - before, elapsed)) << T << " " << peak << " " << n;
        before = now;
      }
    }
  }
}

/// If a scene scales the device's movement by ten, a movement ten times as large belongs to an
/// equal hand movement.
TEST(PossibleMovement, TheLimitIsThatOfTheHandleNotOfTheScene) {
  DeviceSpec spec = builtin_device("simulated");
  const MovementBounds plain = position_bounds(spec);
  spec.position_resolution *= 10.0;
  const MovementBounds far = position_bounds(spec, 10.0);
  EXPECT_DOUBLE_EQ(far.fastest, 10.0 * plain.fastest);
  EXPECT_DOUBLE_EQ(far.knock, 10.0 * plain.knock);
  EXPECT_DOUBLE_EQ(far.pull, 10.0 * plain.pull);
  EXPECT_DOUBLE_EQ(far.error, 10.0 * plain.error);
}

}  // namespace
}  // namespace feltwire::possible_movement_test
