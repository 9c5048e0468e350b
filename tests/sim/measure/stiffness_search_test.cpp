#include "sim/measure/stiffness_search.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace feltwire::stiffness_search_test {
namespace {

constexpr StiffnessRange kRange{.lowest = 10.0, .highest = 1e6, .per_decade = 6, .tolerance = 0.03};

TEST(StiffnessSearch, FindsAnEdgeToItsToleranceFromBelow) {
  for (const double edge : {10.0, 11.0, 99.9, 100.0, 5233.0, 9.99e5}) {
    const StiffnessLimit limit = largest_calm(kRange, [&](double k) { return k <= edge; });
    EXPECT_FALSE(limit.above_range) << edge;
    EXPECT_LE(limit.stiffness, edge);
    EXPECT_GT(limit.stiffness * 1.03, edge);
  }
}

TEST(StiffnessSearch, SaysWhenTheRangeHasNoEdge) {
  const StiffnessLimit all = largest_calm(kRange, [](double) { return true; });
  EXPECT_TRUE(all.above_range);
  EXPECT_EQ(all.stiffness, 1e6);
  int asked = 0;
  const StiffnessLimit nothing = largest_calm(kRange, [&](double) { return ++asked < 1; });
  EXPECT_EQ(asked, 1) << "there is nothing between the lowest and none";
  EXPECT_FALSE(nothing.above_range);
  EXPECT_EQ(nothing.stiffness, 0.0);
}

// A bisection of the complete range would end in the second calm range, beyond the oscillation.
TEST(StiffnessSearch, StopsAtTheFirstOscillationNotBeyondIt) {
  const StiffnessLimit limit =
      largest_calm(kRange, [](double k) { return k <= 300.0 || k > 3000.0; });
  EXPECT_LE(limit.stiffness, 300.0);
  EXPECT_GT(limit.stiffness, 300.0 / 1.03);
}

TEST(StiffnessSearch, NeverAsksOutsideTheRange) {
  std::vector<double> asked;
  largest_calm({.lowest = 20.0, .highest = 500.0, .per_decade = 3, .tolerance = 0.1},
               [&](double k) {
                 asked.push_back(k);
                 return true;
               });
  EXPECT_EQ(asked.front(), 20.0);
  EXPECT_EQ(asked.back(), 500.0);
  for (std::size_t i = 1; i < asked.size(); ++i) {
    EXPECT_GT(asked[i], asked[i - 1]);
    EXPECT_LT(asked[i], asked[i - 1] * 2.16) << "a third of a decade a point";
  }
}

TEST(StiffnessSearch, RefusesARangeThatCannotBeSearched) {
  const auto calm = [](double) { return true; };
  EXPECT_THROW(largest_calm({.lowest = 0.0}, calm), std::invalid_argument);
  EXPECT_THROW(largest_calm({.lowest = 10.0, .highest = 10.0}, calm), std::invalid_argument);
  EXPECT_THROW(largest_calm({.per_decade = 0}, calm), std::invalid_argument);
  EXPECT_THROW(largest_calm({.tolerance = 0.0}, calm), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::stiffness_search_test
