// Studies with a plant: what an untold lag does, and what a told one mends.

#include <gtest/gtest.h>

#include <algorithm>

#include "sim/studies/bound/rate.hpp"
#include "sim/studies/network/where_to_bound.hpp"

namespace feltwire::plant_studies_test {
namespace {

constexpr double kLag = 0.5e-3;  // [s]
Plant late() {
  Plant plant;
  plant.amplifier.delay = kLag;
  return plant;
}

std::vector<RateCell> rate_cells(const Plant& plant, bool told) {
  RateGrid grid;
  grid.rates = {1000.0, 10000.0};
  grid.dampings = {2.0};
  grid.float_too = false;
  grid.plant = plant;
  grid.told = told;
  return run_rate(grid);
}

// On a stiff wall contact_frame displays 2 b / (T + 2 L), and 2 b / T if it does not know L.
TEST(PlantStudies, TheRateStudyDisplaysWhatTheLagLeaves) {
  const auto told = rate_cells(late(), true), untold = rate_cells(late(), false);
  for (std::size_t i = 0; i < 2; ++i) {
    const double period = 1.0 / told[i].rate;
    EXPECT_NEAR(told[i].displayed, 2.0 * 2.0 / (period + 2.0 * kLag), 0.02 * told[i].displayed);
    EXPECT_GT(untold[i].displayed, 1.5 * told[i].displayed);
    EXPECT_LT(told[i].oscillation, 1e-6);
  }
}

std::vector<WhereToBoundCell> sides_cells(const Plant& plant, bool told) {
  WhereToBoundGrid grid;
  grid.round_trips = {0.0};
  grid.jitters = {0.0};
  grid.losses = {{0.0, 0.0}};
  grid.hands = {kEightHands.begin(), kEightHands.end()};
  grid.adversarial_hand = false;
  grid.plant = plant;
  grid.told = told;
  return run_where_to_bound(grid);
}

TEST(PlantStudies, WhereToBoundMeasuresTheTrueMotor) {
  EXPECT_TRUE(bounds_hold(sides_cells(late(), true)));
  EXPECT_FALSE(bounds_hold(sides_cells(late(), false)));
  EXPECT_TRUE(bounds_hold(sides_cells({}, false)));
}

}  // namespace
}  // namespace feltwire::plant_studies_test
