// The study of where to bound must agree with known results, and must detect a wrong bound.

#include "sim/studies/network/where_to_bound.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/support/text_of.hpp"

namespace feltwire::where_to_bound_test {
namespace {

using test::text_of;

WhereToBoundGrid small() {
  return {.round_trips = {0.0, 20e-3}, .jitters = {0.0, 5e-3}, .losses = {{}, {0.3, 8.0}}};
}
const std::vector<WhereToBoundCell>& cells() {
  static const auto all = run_where_to_bound(small());
  return all;
}
const WhereToBoundCell& cell(std::string_view task, std::string_view bound, double round_trip,
                             double jitter = 0.0, double loss = 0.0) {
  return *std::find_if(cells().begin(), cells().end(), [&](const WhereToBoundCell& c) {
    return c.task == task && c.bound == bound && c.round_trip == round_trip && c.jitter == jitter &&
           c.loss.loss == loss;
  });
}

TEST(Sides, EveryCellIsThereOnce) {
  EXPECT_EQ(cells().size(), 5u * 4u * 2u * 2u * 2u);
  EXPECT_EQ(cells().front().bound, "none");
  EXPECT_EQ(cells().back().loss.burst, 8.0);
}

TEST(Sides, NoPortThatIsBoundedGivesMoreThanTheDeviceBurns) {
  EXPECT_TRUE(bounds_hold(cells()));
  for (const WhereToBoundCell& c : cells()) {
    if (c.bound == "none") continue;
    EXPECT_EQ(c.violations, 0u) << c.task << ' ' << c.bound;
    EXPECT_GE(c.margin, -1e-9) << c.task << ' ' << c.bound;
  }
}

TEST(Sides, OverEightHandsNoPortThatIsBoundedGivesMore) {
  WhereToBoundGrid grid = hands_where_to_bound_grid();
  EXPECT_EQ(grid.hands.size(), 8u);
  grid.round_trips = {20e-3};
  const auto by_hands = run_where_to_bound(grid);
  ASSERT_EQ(by_hands.size(), 4u * 4u * 2u * 8u);
  EXPECT_TRUE(bounds_hold(by_hands));
  const WhereToBoundCell& usual = cell("wall 40 kN/m", "client", 20e-3);
  const auto same = std::find_if(by_hands.begin(), by_hands.end(), [](const WhereToBoundCell& c) {
    return c.task == "wall 40 kN/m" && c.bound == "client" && c.hand == kEightHands[0].name;
  });
  EXPECT_EQ(same->displayed, usual.displayed);
  const std::string table = where_to_bound_hands_table(by_hands);
  EXPECT_NE(table.find("taps 1 kN/m"), std::string::npos);
  EXPECT_EQ(table.find("taking hand"), std::string::npos);
  EXPECT_NE(table.find("both        0 of 64"), std::string::npos) << table;
}

TEST(Sides, AWrongDampingIsFoundOutAtEverySetting) {
  WhereToBoundGrid grid = small();
  grid.assumed_damping = 1.05;
  const auto wrong = run_where_to_bound(grid);
  EXPECT_FALSE(bounds_hold(wrong));
  for (const WhereToBoundCell& c : wrong) {
    if (c.task != "taking hand") continue;
    EXPECT_GT(c.violations, 0u) << c.bound << ' ' << c.round_trip << ' ' << c.jitter << ' '
                                << c.loss.loss;
  }
}

// If only the server bounds, the client's account limits the energy but does not stop the
// oscillation.
TEST(Sides, AServerAloneLetsTheHandSwing) {
  EXPECT_GT(cell("sphere 1 kN/m", "server", 20e-3).oscillation, 200e-6);
  EXPECT_LT(cell("sphere 1 kN/m", "client", 20e-3).oscillation, 60e-6);
  EXPECT_LT(cell("wall 1 kN/m", "none", 20e-3).margin, -0.1);  // [J]
}

TEST(Sides, WhatIsDisplayedAndHowOldTheDirectionIs) {
  // min(k, 2 b / T), including the millisecond of a loop without delay
  EXPECT_NEAR(cell("wall 40 kN/m", "server", 0.0).displayed, 1000.0, 20.0);
  EXPECT_NEAR(cell("wall 40 kN/m", "client", 0.0).displayed, 1000.0, 40.0);
  EXPECT_NEAR(cell("wall 1 kN/m", "none", 0.0).displayed, 1000.0, 10.0);
  // a quarter turn per second, during the round trip
  EXPECT_NEAR(cell("sphere 1 kN/m", "client", 0.0).direction_mean, 1e-3 * 1.5708, 1e-4);
  EXPECT_NEAR(cell("sphere 1 kN/m", "client", 20e-3).direction_mean, 20e-3 * 1.5708, 1e-3);
}

// This is the reason why the client bounds alone by default (docs/network.md).
TEST(Sides, OverALossyLineAServersBoundBeforeTheClientsOnlyTakes) {
  const WhereToBoundCell& client = cell("wall 40 kN/m", "client", 20e-3, 0.0, 0.3);
  const WhereToBoundCell& both = cell("wall 40 kN/m", "both", 20e-3, 0.0, 0.3);
  EXPECT_LT(both.displayed, 0.95 * client.displayed);
  // Without loss both results must be equal.
  EXPECT_NEAR(cell("wall 40 kN/m", "client", 20e-3).displayed,
              cell("wall 40 kN/m", "both", 20e-3).displayed, 1e-3);
}

TEST(Sides, TheSameBytesEveryTime) {
  const auto directory =
      std::filesystem::path(::testing::TempDir()) / "feltwire_where_to_bound_test";
  const WhereToBoundGrid grid{.round_trips = {10e-3}, .jitters = {0.0}, .losses = {{}, {0.1, 8.0}}};
  for (const char* turn : {"a", "b"})
    write_where_to_bound(directory / turn, run_where_to_bound(grid));
  for (const char* file : {"sides.csv", "sides.json", "sides.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 500u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  std::filesystem::remove_all(directory);
}

TEST(Sides, TheTableHasEveryTaskAndTheVerdict) {
  const std::string table = where_to_bound_table(cells());
  for (const char* task : {"wall 40 kN/m", "sphere 1 kN/m", "taps 1 kN/m", "taking hand"})
    EXPECT_THAT(table, ::testing::HasSubstr(task));
  EXPECT_THAT(table, ::testing::HasSubstr("server      0 of 40, at most 0 J"));
  EXPECT_THAT(table, ::testing::HasSubstr("client      0 of 40, at most 0 J"));
  EXPECT_THAT(table, ::testing::HasSubstr("both        0 of 40, at most 0 J"));
}

TEST(Sides, RefusesADampingThatIsNone) {
  EXPECT_THROW(run_where_to_bound({.assumed_damping = 0.0}), std::invalid_argument);
  EXPECT_THROW(run_where_to_bound({.assumed_damping = NAN}), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::where_to_bound_test
