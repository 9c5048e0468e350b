// The goals of docs/lab/frontier.md, hand by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sim/studies/bound/frontier.hpp"

namespace feltwire::frontier_hands_test {
namespace {

constexpr double kCalm = 10e-6;  // [m] RMS

std::vector<FrontierRow> over_all_hands(FrontierCase c) {
  std::vector<FrontierCase> cases;
  for (const NamedHand& hand : kEightHands) {
    c.hand = hand;
    cases.push_back(c);
  }
  return run_frontier(cases);
}
FrontierRow row(const FrontierCase& c) { return run_frontier({c}).front(); }

/// The middle of eight hands, the lower one of the two. A hand that swings feels nothing here.
double median_share(const std::vector<FrontierRow>& rows) {
  std::vector<double> shares;
  for (const FrontierRow& r : rows) shares.push_back(r.oscillation < kCalm ? r.displayed : 0.0);
  std::sort(shares.begin(), shares.end());
  return shares[(shares.size() - 1) / 2];
}

TEST(FrontierHands, MostHandsFeelThePapersWall) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    FrontierCase c{.law = "midpoint", .need = Need::inertia_friction, .damping = damping};
    c.cold = false;
    const std::vector<FrontierRow> rows = over_all_hands(c);
    EXPECT_GT(median_share(rows), 0.9) << damping;
    for (const FrontierRow& r : rows) EXPECT_EQ(r.energy_made, 0.0) << r.made.hand.name;
    c.law = "contact_frame";
    EXPECT_LT(median_share(over_all_hands(c)), 0.9) << "the goal says nothing if this law meets it";
  }
}

TEST(FrontierHands, NoHandFeelsLessOfALatePressThanWithTheContactFrame) {
  for (const double delay : {0.0, 5e-3, 20e-3, 50e-3}) {
    FrontierCase c{.task = "press", .law = "credited", .need = Need::inertia_friction};
    c.delay = delay;
    const std::vector<FrontierRow> ours = over_all_hands(c);
    c.law = "contact_frame";
    c.need = Need::no_account;
    const std::vector<FrontierRow> theirs = over_all_hands(c);
    for (std::size_t i = 0; i < ours.size(); ++i)
      EXPECT_GT(ours[i].displayed, 0.95 * theirs[i].displayed)
          << delay << ' ' << ours[i].made.hand.name;
  }
}

TEST(FrontierHands, ALateCornerIsFelt) {
  FrontierCase c{
      .task = "corner", .law = "credited", .need = Need::inertia_friction, .damping = 2.0};
  c.delay = 5e-3;
  const FrontierRow ours = row(c);
  EXPECT_GT(ours.displayed, 0.65);
  EXPECT_LT(ours.oscillation, kCalm);
  EXPECT_EQ(ours.energy_made, 0.0);
}

TEST(FrontierHands, TapsOnAStiffWallAreFelt) {
  FrontierCase c{.task = "tap", .law = "midpoint", .need = Need::inertia_friction};
  EXPECT_GT(row(c).displayed * c.wall, 20e3);
  c.law = "contact_frame";
  c.need = Need::no_account;
  EXPECT_LT(row(c).displayed * c.wall, 5e3);
}

TEST(FrontierHands, ATremorDoesNotDrainAPressForHalfAMinute) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    FrontierCase c{
        .task = "tremor", .law = "midpoint", .need = Need::inertia_friction, .damping = damping};
    c.cold = false;
    const FrontierRow r = row(c);
    EXPECT_GT(r.displayed, 0.9) << damping;
    EXPECT_EQ(r.energy_made, 0.0) << damping;
  }
}

TEST(FrontierHands, MassAloneCarriesAFirstPress) {
  FrontierCase c{
      .task = "press", .law = "midpoint", .need = Need::inertia, .device = kFrontierDevices[1]};
  c.damping = 0.5;
  c.wall = 5e3;
  EXPECT_GT(row(c).displayed, 0.9);
  c.damping = 0.005;
  c.wall = 1e3;
  EXPECT_GT(row(c).displayed, 0.99);
}

}  // namespace
}  // namespace feltwire::frontier_hands_test
