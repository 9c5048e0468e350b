#include "sim/studies/scene/trade_mass.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace feltwire::trade_mass_test {
namespace {

MassGrid small() {
  return {.masses = {0.1},
          .stiffnesses = {1e3, 1e6},
          .periods = {1e-3, 2e-3},
          .finer = 10,
          .task_time = 0.2,
          .throw_time = 0.3,
          .cost_steps = 50};
}

double error_of(const MassTrade& trade, const std::string& way, double period) {
  for (const MassAccuracy& c : trade.accuracy)
    if (c.task == "sway" && c.way == way && c.period == period) return c.force_error;
  ADD_FAILURE() << way;
  return 0.0;
}

TEST(TradeMass, FinerStepsErrLessAndNoneFeelsNoInertia) {
  const MassTrade trade = run_trade_mass(small());
  EXPECT_EQ(trade.accuracy.size(), 2u * 3u * 2u);
  EXPECT_EQ(trade.stability.size(), 3u * 2u);
  EXPECT_EQ(trade.cost.size(), 6u);
  EXPECT_NEAR(error_of(trade, "none", 1e-3), 1.0, 0.05);
  for (const char* way : {"implicit", "midpoint"}) {
    EXPECT_LT(error_of(trade, way, 1e-3), 0.05);
    EXPECT_GT(error_of(trade, way, 2e-3), 1.5 * error_of(trade, way, 1e-3));
  }
  EXPECT_LT(error_of(trade, "midpoint", 1e-3), 0.9 * error_of(trade, "implicit", 1e-3));
}

TEST(TradeMass, NoToolGainsEnergy) {
  for (const MassStability& c : run_trade_mass(small()).stability)
    EXPECT_LE(c.most, 1.0 + 1e-9) << c.way << ' ' << c.stiffness;
}

TEST(TradeMass, TheSameBytesEveryTimeButForTheCost) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_trade_mass";
  const auto text_of = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  write_trade_mass(directory / "a", run_trade_mass(small()));
  write_trade_mass(directory / "b", run_trade_mass(small()));
  for (const char* file : {"trade_mass.csv", "trade_mass_stability.csv", "trade_mass.png"}) {
    EXPECT_GT(text_of(directory / "a" / file).size(), 100u) << file;
    EXPECT_EQ(text_of(directory / "a" / file), text_of(directory / "b" / file)) << file;
  }
  EXPECT_GT(text_of(directory / "a" / "trade_mass_cost.csv").size(), 100u);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::trade_mass_test
