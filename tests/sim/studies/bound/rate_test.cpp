// The trade-off between servo rate and arithmetic type must agree with theory.

#include "sim/studies/bound/rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/text_of.hpp"

namespace feltwire::rate_test {
namespace {

using test::text_of;

const std::vector<RateCell>& cells() {
  static const auto all = run_rate({.rates = {500, 1000, 4000}, .dampings = {0.5, 2.0}});
  return all;
}
const RateCell& cell(const char* surface, double damping, double rate,
                     std::string_view arithmetic) {
  return *std::find_if(cells().begin(), cells().end(), [&](const RateCell& c) {
    return c.surface == surface && c.damping == damping && c.rate == rate &&
           c.arithmetic == arithmetic;
  });
}

// A press from rest with the contact frame must display min(k, 2 b / T).
TEST(Rate, DisplaysTheStiffnessOrTwiceTheDampingOverThePeriod) {
  ASSERT_EQ(cells().size(), 3u * 2u * 3u * 3u);
  for (const RateCell& c : cells()) {
    const double stiffness = c.surface == "wall 40 kN/m"  ? 4e4
                             : c.surface == "wall 1 kN/m" ? 1e3
                                                          : 5e3;
    const double expected = std::min(stiffness, 2.0 * c.damping * c.rate);
    EXPECT_NEAR(c.displayed, expected, 0.03 * expected)
        << c.surface << ' ' << c.damping << ' ' << c.rate << ' ' << c.arithmetic;
  }
}

TEST(Rate, TheDirectionOnASphereIsAsOldAsTheSample) {
  const double slow = cell("sphere 5 kN/m", 2.0, 500, "double").direction_error;
  const double fast = cell("sphere 5 kN/m", 2.0, 4000, "double").direction_error;
  // a quarter turn per second, during T
  EXPECT_NEAR(slow, 2e-3 * 2.0 * 3.14159 * 0.25, 0.1 * slow);
  EXPECT_LT(fast, slow / 6.0);
}

TEST(Rate, FloatIsAsGoodAsTheEncoder) {
  for (const RateCell& c : cells()) {
    const RateCell& exact = cell(c.surface.c_str(), c.damping, c.rate, "double");
    EXPECT_NEAR(c.displayed, exact.displayed, 0.01 * exact.displayed);
    EXPECT_NEAR(c.direction_error, exact.direction_error, 1e-3) << c.surface;  // [rad]
    EXPECT_NEAR(c.oscillation, exact.oscillation, 2e-6) << c.surface;
  }
  // The arithmetic must be float, so some numbers must differ.
  EXPECT_NE(cell("wall 40 kN/m", 2.0, 4000, "float 1 m").displayed,
            cell("wall 40 kN/m", 2.0, 4000, "double").displayed);
}

TEST(Rate, OverEightHandsTheSameStiffnessIsDisplayed) {
  RateGrid grid = hands_rate_grid();
  EXPECT_EQ(grid.hands.size(), 8u);
  grid.rates = {1000};
  grid.dampings = {2.0};
  const auto by_hands = run_rate(grid);
  ASSERT_EQ(by_hands.size(), 3u * 8u);
  for (std::size_t i = 0; i < by_hands.size(); ++i)
    EXPECT_EQ(by_hands[i].hand, kEightHands[i % 8].name);
  EXPECT_EQ(by_hands[0].displayed, cell("wall 40 kN/m", 2.0, 1000, "double").displayed);
  const std::string table = rate_hands_table(by_hands);
  EXPECT_NE(table.find("sphere 5 kN/m"), std::string::npos);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 4 + 3 + 2);
}

TEST(Rate, TheSameBytesEveryTimeButForTheCost) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_rate_test";
  const RateGrid grid{.rates = {500, 1000}, .dampings = {0.5}};
  double cost = 30.0;
  for (const char* turn : {"a", "b"}) {
    write_rate(directory / turn, grid, run_rate(grid),
               {{"wall 40 kN/m", cost, cost, cost},
                {"wall 1 kN/m", cost, cost, cost},
                {"sphere 5 kN/m", cost, cost, cost}});
    cost *= 2.0;
  }
  for (const char* file : {"rate.csv", "rate.json", "rate.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 500u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  EXPECT_NE(text_of(directory / "a" / "rate_cost.csv"), text_of(directory / "b" / "rate_cost.csv"));
  // 1 kHz of 30 ns of contact plus 30 ns of bound
  EXPECT_NE(text_of(directory / "a" / "rate_cost.csv").find("wall 1 kN/m,0.5,1000,double,0.006,"),
            std::string::npos);
  std::filesystem::remove_all(directory);
}

TEST(Rate, EverySurfaceHasItsCost) {
  const std::vector<RateCost> costs = measure_rate_cost();
  std::vector<std::string> measured, ran;
  for (const RateCost& cost : costs) measured.push_back(cost.surface);
  for (const RateCell& c : cells())
    if (ran.empty() || ran.back() != c.surface) ran.push_back(c.surface);
  EXPECT_EQ(measured, ran);
  for (const RateCost& cost : costs) {
    EXPECT_GT(cost.touch_ns, 0.0) << cost.surface;
    EXPECT_GT(cost.bound_double_ns, 0.0) << cost.surface;
    EXPECT_GT(cost.bound_float_ns, 0.0) << cost.surface;
  }
}

}  // namespace
}  // namespace feltwire::rate_test
