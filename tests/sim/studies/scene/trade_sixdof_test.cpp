#include "sim/studies/scene/trade_sixdof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>

#include "core/mesh/tessellation.hpp"
#include "sim/studies/scene/finer_surface.hpp"
#include "sim/studies/scene/sixdof_tool.hpp"

namespace feltwire::trade_sixdof_test {
namespace {

/// Uses a quarter of the time, so the hand moves four times faster than in the study.
SixDofGrid small() {
  return {.points = 300,
          .grid_steps = 16.0,
          .finer = 4,
          .slower = 0.25,
          .bunny_tolerance = 8e-3,
          .fine_triangles = 0,
          .cost_laps = 1,
          .hand_time = 0.1,
          .stiffness = {.lowest = 1000.0, .highest = 1e5, .per_decade = 2, .tolerance = 0.5}};
}

const std::vector<SixDofCell>& cells() {
  static const std::vector<SixDofCell> all = run_trade_sixdof(small());
  return all;
}

const SixDofCell& cell(const std::string& task, const std::string& contact,
                       const std::string& mass) {
  for (const SixDofCell& c : cells())
    if (c.task == task && c.contact == contact && c.mass == mass) return c;
  throw std::logic_error("no row of " + task + ' ' + contact + ' ' + mass);
}

TEST(TradeSixDof, EveryRowIsThereAndFinite) {
  EXPECT_EQ(cells().size(), 7u * 6u);
  for (const char* task : {"peg 0.5", "peg 0.1", "gears", "chain", "edge", "ridge", "bunny"})
    for (const std::string contact : {"points", "polygons"})
      for (const std::string mass : {"none", "implicit", "midpoint"}) {
        if (contact == "points" && mass == "midpoint") continue;
        const SixDofCell& c = cell(task, contact, mass);
        const std::string name = c.task + ' ' + c.contact + ' ' + c.mass;
        for (const double number :
             {c.force_error, c.torque_error, c.reference_force_error, c.reference_torque_error,
              c.largest_force, c.jump, c.reference_jump, c.stable.stiffness})
          EXPECT_TRUE(std::isfinite(number) && number >= 0.0) << name;
        EXPECT_GT(c.largest_force, 0.05) << name;
        EXPECT_GT(c.median_ns, 0.0) << name;
        EXPECT_GE(c.p99_9_ns, c.median_ns) << name;
        EXPECT_GT(c.bytes, 1000u) << name;
      }
}

TEST(TradeSixDof, PolygonsAreExactAndDoNotJump) {
  for (const char* task : {"peg 0.5", "peg 0.1", "edge"}) {
    const SixDofCell& c = cell(task, "polygons", "none");
    EXPECT_LT(c.jump, 0.2) << task;
    EXPECT_LT(c.force_error, 0.02) << task;
    EXPECT_LT(c.torque_error, 0.02) << task;
    EXPECT_LT(c.reference_force_error, 0.01) << task;
  }
}

/// On a ridge a massless tool cannot rest. The tool jumps from one side to the other.
TEST(TradeSixDof, AMassTakesTheJumpOverARidge) {
  for (const char* contact : {"points", "polygons"}) {
    EXPECT_GT(cell("ridge", contact, "none").reference_jump, 0.5) << contact;
    EXPECT_LT(cell("ridge", contact, "implicit").jump,
              0.5 * cell("ridge", contact, "none").reference_jump)
        << contact;
  }
}

TEST(TradeSixDof, GearsAndLinksAreTheSameSolidByBothWays) {
  for (const CutSolid& solid :
       {gear_solid({}), link_solid({}), box_solid(Vec3(0.01, 0.02, 0.03))}) {
    const TriangleMesh mesh(solid.surface);
    EXPECT_TRUE(mesh.report().closed());
    double volume = 0.0;
    for (const auto& part : solid.parts) volume += convex_hull(part)->volume;
    EXPECT_NEAR(volume, mesh.report().volume, 1e-6 * volume);
  }
}

/// A ball of few triangles must become rounder, stay closed and keep its corners.
TEST(TradeSixDof, AFinerSurfaceIsClosedAndSmoother) {
  constexpr double kRadius = 0.05;
  const TriangleSoup ball = tessellate(Sphere{kRadius}, 16);
  const auto farthest = [&](const TriangleSoup& surface) {
    double most = 0.0;
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3 middle = (surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3.0;
      most = std::max(most, kRadius - middle.norm());
    }
    return most;
  };
  for (const std::size_t triangles :
       {ball.triangles.size() + 1, 4 * ball.triangles.size(), 5000ul}) {
    const TriangleSoup finer = finer_surface(ball, triangles);
    EXPECT_GE(finer.triangles.size(), triangles);
    EXPECT_LE(finer.triangles.size(), triangles + 1);
    EXPECT_TRUE(TriangleMesh(finer).report().closed());
    EXPECT_TRUE(
        std::ranges::equal(ball.vertices, std::span(finer.vertices).first(ball.vertices.size())));
    if (triangles >= 4 * ball.triangles.size()) {
      EXPECT_LT(farthest(finer), 0.5 * farthest(ball));
    }
  }
}

/// Both rules converge to one movement. The second-order rule must be nearer to this movement.
TEST(TradeSixDof, TheMidpointRuleErrsLessThanBackwardEuler) {
  for (const char* task : {"peg 0.5", "gears", "chain", "edge"})
    EXPECT_LT(cell(task, "polygons", "midpoint").force_error,
              0.75 * cell(task, "polygons", "implicit").force_error)
        << task;
}

/// An equal spring moves an equal tool. The forces must agree except for the contact law.
TEST(TradeSixDof, MuJoCoHasTheSameTasks) {
  for (const char* task : {"peg 0.5", "peg 0.1", "gears", "chain", "edge"}) {
    const SixDofCell &other = cell(task, "mujoco", "euler"),
                     &own = cell(task, "polygons", "implicit");
    EXPECT_GT(other.largest_force, 0.5 * own.largest_force) << task;
    EXPECT_LT(other.largest_force, 2.0 * own.largest_force) << task;
    EXPECT_LT(other.force_error, 1.0) << task;
    EXPECT_GT(other.median_ns, 0.0) << task;
    EXPECT_GT(other.bytes, 1000u) << task;
  }
}

/// Two springs are in series: the material's (the face is the contact area) and the coupling's.
TEST(TradeSixDof, TheBoxOnTheTableHasTheForceOfItsClosedForm) {
  constexpr double kDeep = 1e-3;  // [m]
  for (const SixDofTask& task : sixdof_tasks(small().bunny_tolerance, 0, {"edge"})) {
    for (const bool polygons : {false, true}) {
      const SixDofTool made = sixdof_tool(task, {.polygons = polygons}, 20000, small().grid_steps);
      BodyMemory memory;
      Pose device = task.device(0.0);
      made.step(device, kSixDofPeriod, memory);
      device.position.z() = 0.01 - kDeep;
      BodyStep now;
      for (int n = 0; n < 20; ++n) now = made.step(device, kSixDofPeriod, memory);
      const double expected = 0.5 * kSixDofStiffness * kDeep;
      EXPECT_NEAR(now.command.force().z(), expected, (polygons ? 1e-3 : 0.03) * expected);
    }
  }
}

TEST(TradeSixDof, TheSameBytesEveryTimeButForTheTimes) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_trade_sixdof";
  const auto text_of = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  SixDofGrid grid = small();
  grid.tasks = {"peg 0.5", "edge"};
  const std::vector<SixDofCell> first = run_trade_sixdof(grid);
  ASSERT_EQ(first.size(), 2u * 6u);
  write_trade_sixdof(directory / "a", first);
  write_trade_sixdof(directory / "b", run_trade_sixdof(grid));
  for (const char* file : {"trade_sixdof.csv", "trade_sixdof.json"}) {
    EXPECT_GT(text_of(directory / "a" / file).size(), 1000u) << file;
    EXPECT_EQ(text_of(directory / "a" / file), text_of(directory / "b" / file)) << file;
  }
  const std::string costs = text_of(directory / "a" / "trade_sixdof_cost.csv");
  EXPECT_GT(costs.size(), 300u);
  EXPECT_EQ(std::ranges::count(costs, '\n'), static_cast<long>(first.size()) + 1);
  EXPECT_NE(trade_sixdof_table(first).find("edge      polygons  implicit"), std::string::npos);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::trade_sixdof_test
