// Tests the orderings in docs/lab/laboratory.md. A map must be complete and reproducible.

#include "sim/studies/bound/zwidth.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/text_of.hpp"

namespace feltwire::zwidth_test {
namespace {

using test::text_of;

TEST(Methods, LabelsAreDistinctAndFound) {
  std::set<std::string_view> labels;
  for (const Method& m : methods()) {
    EXPECT_TRUE(labels.insert(m.label).second) << m.label;
    EXPECT_EQ(method(m.label).configure, m.configure);
    BoundingConfig config;
    m.apply(config);
    EXPECT_NO_THROW(Bounding{config}) << m.label;
  }
  EXPECT_THROW(method("nothing"), std::invalid_argument);
}

// Without a bound the displayed stiffness is that of the wall. The contact frame limits the
// displayed stiffness to 2 b / T, and the paper's per-axis bound to b / T. Encoder steps cause an
// error of some percent.
TEST(ZWidth, DisplayedStiffnessIsTheWallsOrWhatTheLawAllows) {
  const auto displayed = [](const char* label, double rate, double stiffness) {
    return press_wall(method(label), 2.0, rate, 0.0, stiffness).displayed.value_or(0.0);
  };
  for (const double stiffness : {200.0, 1000.0}) {
    EXPECT_NEAR(displayed("none", 1000, stiffness), stiffness, 0.03 * stiffness);
    EXPECT_NEAR(displayed("contact_frame", 1000, stiffness), stiffness, 0.03 * stiffness);
  }
  for (const double rate : {500.0, 1000.0, 2000.0}) {
    EXPECT_NEAR(displayed("contact_frame", rate, 1e5), 4.0 * rate, 0.1 * 4.0 * rate);
    EXPECT_NEAR(displayed("per_axis", rate, 1e5), 2.0 * rate, 0.1 * 2.0 * rate);
  }
}

TEST(ZWidth, NoneOscillatesOnAStiffOrDelayedWallContactFrameDoesNot) {
  for (const double delay : {0.0, 5e-3, 20e-3}) {
    EXPECT_FALSE(press_wall(method("none"), 0.5, 1000, delay, 40e3).calm()) << delay;
    EXPECT_TRUE(press_wall(method("contact_frame"), 0.5, 1000, delay, 40e3).calm()) << delay;
  }
  EXPECT_TRUE(press_wall(method("none"), 0.5, 1000, 0.0, 1000).calm());
  EXPECT_FALSE(press_wall(method("none"), 0.5, 1000, 0.0, 40e3).displayed.has_value())
      << "an oscillating wall has no stiffness to speak of";
}

TEST(ZWidth, OverEightHandsTheMedianAndTheWorst) {
  ZWidthGrid grid = hands_zwidth_grid();
  EXPECT_EQ(grid.hands.size(), 8u);
  grid.methods = {method("none"), method("contact_frame")};
  grid.dampings = {0.5};
  grid.delays = {0.0};
  grid.range = {.lowest = 1000.0, .highest = 1e4, .per_decade = 2, .tolerance = 0.5};
  const auto cells = map_zwidth(grid);
  ASSERT_EQ(cells.size(), 16u);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].hand, kEightHands[i % 8].name);
    const Press same = press_wall(method(cells[i].method), 0.5, 1000.0, 0.0, kFixedStiffness,
                                  grid.hands[i % 8].hand);
    EXPECT_EQ(cells[i].at_fixed.oscillation, same.oscillation) << cells[i].hand;
  }
  const std::string table = zwidth_hands_table(cells);
  EXPECT_NE(table.find("8/8"), std::string::npos) << "contact_frame: every hand is calm\n" << table;
  EXPECT_NE(table.find("4/8"), std::string::npos) << "none: four of them are not\n" << table;
}

ZWidthGrid small_grid() {
  ZWidthGrid grid;
  grid.methods = {method("none"), method("contact_frame")};
  grid.dampings = {0.5, 2.0};
  grid.rates = {500, 1000};
  grid.delays = {0.0, 5e-3};
  grid.range = {.lowest = 100.0, .highest = 1e5, .per_decade = 3, .tolerance = 0.1};
  return grid;
}

TEST(ZWidth, DelayCostsAndRateAndDampingGiveStiffness) {
  const auto cells = map_zwidth(small_grid());
  const auto limit = [&](std::size_t damping, std::size_t rate, std::size_t delay) {
    return cells[(damping * 2 + rate) * 2 + delay].limit.stiffness;  // the result for method "none"
  };
  for (const std::size_t damping : {0u, 1u}) {
    for (const std::size_t rate : {0u, 1u})
      EXPECT_LT(limit(damping, rate, 1), 0.5 * limit(damping, rate, 0));
    EXPECT_GT(limit(damping, 1, 0), 1.5 * limit(damping, 0, 0));
  }
  EXPECT_GT(limit(1, 1, 0), limit(0, 1, 0));
  for (std::size_t i = 8; i < 16; ++i) EXPECT_TRUE(cells[i].limit.above_range) << "contact_frame";
}

TEST(ZWidth, WritesEveryCellAndTheSameBytesEveryTime) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_zwidth_test";
  std::filesystem::remove_all(directory);
  const ZWidthGrid grid = small_grid();
  const auto cells = write_zwidth(directory, grid);
  ASSERT_EQ(cells.size(), 16u);
  const std::string text = text_of(directory / "zwidth.json");
  const auto json = nlohmann::json::parse(text);
  ASSERT_EQ(json["cells"].size(), 16u);
  EXPECT_NEAR(json["quantum_limit"].get<double>(), 0.2 / 23e-6, 1e-6);
  EXPECT_EQ(json["cells"][1]["delay_samples"], 3) << "5 ms at 500 Hz are 2.5 samples";
  for (const auto& cell : json["cells"])
    EXPECT_EQ(cell["above_quantum_limit"], cell["max_stiffness"] > 0.2 / 23e-6);
  for (const char* picture : {"zwidth_b0.5.png", "zwidth_b2.png"})
    EXPECT_GT(std::filesystem::file_size(directory / picture), 10000u);

  const std::string csv = text_of(directory / "zwidth.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 17);
  write_zwidth(directory, grid);
  EXPECT_EQ(text_of(directory / "zwidth.json"), text);
  EXPECT_EQ(text_of(directory / "zwidth.csv"), csv);
  const std::string table = zwidth_table(cells, grid);
  EXPECT_NE(table.find("contact_frame                    8 of 8     8 of 8\n"), std::string::npos)
      << table;
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::zwidth_test
