// Tests the last stage of a tick alone: reasons for zero force, device trouble and statistics.

#include "client/servo/explanation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace feltwire::explanation_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

Command up(double force) { return {.elastic = Vec3(0, 0, force)}; }

/// Returns a trail in which each stage passes the command on unchanged.
ForceTrail passed(const Command& c) {
  ForceTrail trail;
  trail.reply.answered = true;
  trail.command = {.asked = c, .actuated = c, .faded = c, .bounded = c, .safe = c, .paid = c};
  return trail;
}

struct Told {
  ZeroForceReason tick(const ForceTrail& trail, const Command& held, const Vec3& way = {0, 0, 0}) {
    explanation.trail() = trail;
    explanation.take({.displacement = way,
                      .wanted = trail.command.actuated,
                      .held = held,
                      .elapsed = kPeriod,
                      .known = trail.device.usable,
                      .feels_scene = trail.device.usable},
                     statistics);
    return explanation.reason();
  }
  bool says(HandReason reason, const Explanation::State& state = {}) const {
    return (explanation.reasons(state) & bit(reason)) != 0;
  }
  Explanation explanation{kPeriod};
  ServoStatistics statistics;
};

TEST(Explanation, NamesTheFirstStageThatLeavesNothing) {
  Told told;
  EXPECT_EQ(told.tick(passed(up(1)), up(1)), ZeroForceReason::felt);
  ForceTrail bounded = passed(up(1));
  bounded.command.bounded = bounded.command.safe = bounded.command.paid = {};
  EXPECT_EQ(told.tick(bounded, {}), ZeroForceReason::bound);
  ForceTrail unpaid = passed(up(1));
  unpaid.command.paid = {};
  EXPECT_EQ(told.tick(unpaid, {}), ZeroForceReason::account);
  EXPECT_TRUE(told.says(HandReason::account));
  EXPECT_EQ(told.tick(passed(up(1)), {}), ZeroForceReason::not_held);
  EXPECT_TRUE(told.says(HandReason::device_fault, {.on_time = true}));
  EXPECT_FALSE(told.says(HandReason::device_fault, {.on_time = false})) << "it comes later";
  for (const auto reason : {ZeroForceReason::felt, ZeroForceReason::bound, ZeroForceReason::account,
                            ZeroForceReason::not_held})
    EXPECT_EQ(told.statistics.no_force[static_cast<std::size_t>(reason)], 1u);
}

TEST(Explanation, TellsWhoGaveTheForce) {
  Told told;
  told.tick(passed(up(1)), up(1));
  EXPECT_TRUE(told.says(HandReason::near, {.near = true}));
  EXPECT_TRUE(told.says(HandReason::late, {.near = false}));
  told.tick(passed({}), {});
  EXPECT_FALSE(told.says(HandReason::near, {.near = true})) << "there is none";
}

TEST(Explanation, AFadeIsAReasonOnlyWhileTheSessionGoesOn) {
  Told told;
  ForceTrail faded = passed(up(1));
  faded.command.faded = faded.command.bounded = faded.command.safe = faded.command.paid = up(0.5);
  told.tick(faded, up(0.5));
  EXPECT_TRUE(told.says(HandReason::faded));
  EXPECT_FALSE(told.says(HandReason::faded, {.fades = true}));
  EXPECT_TRUE(told.says(HandReason::reconnecting, {.fades = true}));
  EXPECT_FALSE(told.says(HandReason::reconnecting, {.fades = true, .law_changes = true}));
}

TEST(Explanation, TheShareOfTheAccountIsWhatItTookOff) {
  Told told;
  ForceTrail cut = passed(up(2));
  cut.command.paid = up(0.5);
  told.tick(cut, up(0.5));
  EXPECT_NEAR(told.explanation.account_cut(), 0.75, 1e-12);
  told.tick(passed({}), {});
  EXPECT_EQ(told.explanation.account_cut(), 0.0);
}

TEST(Explanation, CountsHowLongADeviceKeepsTheForce) {
  Told told;
  for (int n = 0; n < 7; ++n) told.tick(passed(up(1)), {});
  EXPECT_NEAR(told.explanation.not_held_for(), 7 * kPeriod, 1e-12);
  told.tick(passed({}), {});  // A zero command does not show whether the device holds forces.
  EXPECT_NEAR(told.explanation.not_held_for(), 7 * kPeriod, 1e-12);
  told.tick(passed(up(1)), up(1));
  EXPECT_EQ(told.explanation.not_held_for(), 0.0);
}

/// A hand presses 1 mm into a wall of 500 N/m. The device turns the force by 30 degrees.
TEST(Explanation, MeasuresStiffnessAndDirection) {
  Told told;
  const double angle = 30.0;  // [deg]
  const double c = std::cos(angle * std::numbers::pi / 180.0);
  const double s = std::sin(angle * std::numbers::pi / 180.0);
  for (int n = 1; n <= 100; ++n) {
    const double force = 500.0 * n * 1e-5;
    told.tick(passed(up(force)), {.elastic = force * Vec3(s, 0, c) / c}, {0, 0, -1e-5});
  }
  ASSERT_TRUE(told.explanation.measures().displayed_stiffness());
  EXPECT_NEAR(*told.explanation.measures().displayed_stiffness(), 500.0, 1e-6);
  EXPECT_NEAR(1e-6 * static_cast<double>(told.statistics.direction_error.quantile(0.5)), angle,
              0.1 * angle);
  EXPECT_NEAR(told.statistics.max_force, 0.5 / c, 1e-12);
}

}  // namespace
}  // namespace feltwire::explanation_test
