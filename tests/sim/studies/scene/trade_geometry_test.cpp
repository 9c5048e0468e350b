// The statements of the trade study on geometry and tools must hold for small grids too.

#include "sim/studies/scene/trade_geometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/studies/scene/trade_tools.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::trade_geometry_test {
namespace {

using test::text_of;

const std::vector<GeometryCell>& cells() {
  static const auto all = run_trade_geometry({.levels = {2, 3}, .resolutions = {8e-3, 4e-3}});
  return all;
}

const GeometryCell& cell(const std::string& kind, const std::string& arithmetic, double size) {
  return *std::find_if(cells().begin(), cells().end(), [&](const GeometryCell& c) {
    return c.kind == kind && c.arithmetic == arithmetic && c.size == size;
  });
}

TEST(TradeGeometry, TheSolidIsExactAndTheRestErrsByItsOrder) {
  EXPECT_LT(cells().front().force_error, 1e-12);
  const auto ratio = [](const GeometryCell& coarse, const GeometryCell& fine) {
    return coarse.direction_error / fine.direction_error;
  };
  // Facets of half the size rotate the normal by half as much. The error of the normal is linear in
  // the resolution, and the error of the distance is quadratic.
  for (const char* kind : {"mesh, nearest", "mesh, proxy"})
    EXPECT_NEAR(ratio(cell(kind, "double", 320), cell(kind, "double", 1280)), 2.0, 0.6) << kind;
  // The proxy stays on its facet until it passes an edge. Elsewhere the proxy is the nearest point.
  const GeometryCell &nearest = cell("mesh, nearest", "double", 1280),
                     &proxy = cell("mesh, proxy", "double", 1280);
  EXPECT_NEAR(proxy.direction_error, nearest.direction_error, 1e-4);
  EXPECT_NEAR(proxy.force_error, nearest.force_error, 1e-4);
  EXPECT_NEAR(cell("mesh, proxy", "float", 1280).direction_error, proxy.direction_error, 1e-6);
  EXPECT_NEAR(ratio(cell("grid, linear", "float", 8e-3), cell("grid, linear", "float", 4e-3)), 2.0,
              0.6);
  EXPECT_GT(ratio(cell("grid, quadratic", "float", 8e-3), cell("grid, quadratic", "float", 4e-3)),
            3.0);
  EXPECT_LT(cell("grid, quadratic", "float", 4e-3).jump,
            0.01 * cell("grid, linear", "float", 4e-3).jump);
  for (const GeometryCell& c : cells()) {
    EXPECT_GT(c.glide_ns, 0.0) << c.kind;
    EXPECT_GT(c.scattered_ns, 0.0) << c.kind;
    EXPECT_GT(c.bytes, 0.0) << c.kind;
  }
}

TEST(TradeGeometry, TheSameBytesEveryTimeButForTheCost) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_trade_geometry";
  const GeometryGrid grid{.levels = {2}, .resolutions = {8e-3}};
  write_trade_geometry(directory / "a", run_trade_geometry(grid));
  write_trade_geometry(directory / "b", run_trade_geometry(grid));
  for (const char* file : {"trade_geometry.csv", "trade_geometry.json", "trade_geometry.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 100u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  EXPECT_GT(text_of(directory / "a" / "trade_geometry_cost.csv").size(), 100u);
  std::filesystem::remove_all(directory);
}

const ToolsGrid kSmall{.points = {300, 3000}, .reference = 30'000, .poses = 8, .steps = 20};

TEST(TradeTools, MorePointsErrLess) {
  const auto tools = run_trade_tools(kSmall);
  ASSERT_EQ(tools.size(), 3u * kSmall.points.size());
  for (std::size_t i = 0; i < tools.size(); i += 2) {
    const ToolsCell &few = tools[i], &many = tools[i + 1];
    EXPECT_EQ(few.task, many.task);
    EXPECT_LT(many.force_error, few.force_error) << few.task;
    EXPECT_LT(many.torque_error, few.torque_error) << few.task;
    EXPECT_LT(many.force_error, 0.05) << few.task;
    EXPECT_NEAR(many.touching / few.touching, 10.0, 4.0) << few.task;
    EXPECT_GT(many.contact_ns, 0.0);
  }
}

TEST(TradeTools, TheSameBytesEveryTimeButForTheCost) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_trade_tools";
  const ToolsGrid grid{.points = {100, 300}, .reference = 1000, .poses = 2, .steps = 5};
  write_trade_tools(directory / "a", run_trade_tools(grid));
  write_trade_tools(directory / "b", run_trade_tools(grid));
  for (const char* file : {"trade_tools.csv", "trade_tools.json", "trade_tools.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 100u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  EXPECT_GT(text_of(directory / "a" / "trade_tools_cost.csv").size(), 100u);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::trade_geometry_test
