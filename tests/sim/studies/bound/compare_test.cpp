#include "sim/studies/bound/compare.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "sim/measure/surfaces.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::compare_test {
namespace {

using test::text_of;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFelt = 10e-6;  // [m]

CompareTask task(const std::string& name) {
  for (const CompareTask& t : compare_tasks())
    if (t.name == name) return t;
  throw std::invalid_argument(name);
}

ExperimentSetup unbounded(const CompareTask& task) {
  ExperimentSetup setup;
  setup.hand.spec = builtin_device("simulated");
  setup.hand.task = task.hand;
  setup.duration = task.duration;
  setup.bounding.mode = "none";
  return setup;
}

TEST(CompareTasks, TheTapStrikesAtOneMetreASecond) {
  const CompareTask tap = task("tap");
  const auto samples = run_experiment(tap.touch, unbounded(tap));
  std::size_t n = 1;
  while (n < samples.size() && tap.distance(samples[n].position) > 0.0) ++n;
  ASSERT_LT(n, samples.size());
  const Vec3 way = samples[n - 1].position - samples[n - 2].position;  // still in free space
  EXPECT_NEAR(way.norm() / 1e-3, 1.0, 0.01);
}

TEST(CompareTasks, BeginOutsideAndPressWithSomeNewtons) {
  for (const CompareTask& t : compare_tasks()) {
    const auto samples = run_experiment(t.touch, unbounded(t));
    EXPECT_GT(t.distance(samples.front().position), 0.0) << t.name;
    double largest = 0.0;
    for (const ExperimentSample& s : samples)
      if (s.time > 0.5 * t.duration) largest = std::max(largest, s.rendered.force().norm());
    EXPECT_GT(largest, 2.5) << t.name;
  }
}

TEST(CompareTasks, TheEdgeIsGlidedOverAndLeft) {
  const CompareTask edge = task("edge");
  int on_x = 0, on_y = 0, free = 0;
  for (const ExperimentSample& s : run_experiment(edge.touch, unbounded(edge))) {
    const Vec3 force = s.commanded.elastic;
    on_x += force.x() > 1.0;
    on_y += force.y() > 1.0;
    free += force.norm() == 0.0 && s.time > 4.0;
    EXPECT_TRUE(force.x() == 0.0 || force.y() == 0.0) << "one face at a time";
  }
  EXPECT_GT(on_x, 800);
  EXPECT_GT(on_y, 800);
  EXPECT_GT(free, 500);
}

TEST(CompareTasks, TheCornersWallsAreLeftAndMetAgain) {
  const CompareTask corner = task("corner");
  int three = 0, two = 0;
  for (const ExperimentSample& s : run_experiment(corner.touch, unbounded(corner))) {
    if (s.time < 4.0) continue;
    const int walls = static_cast<int>((s.commanded.elastic.array() > 0.0).count());
    three += walls == 3;
    two += walls == 2;
  }
  EXPECT_GT(three, 1000);
  EXPECT_GT(two, 500);
}

const CompareRow& row(const std::vector<CompareRow>& rows, const std::string& task,
                      const std::string& method) {
  return *std::find_if(rows.begin(), rows.end(),
                       [&](const CompareRow& r) { return r.task == task && r.method == method; });
}

TEST(Compare, TellsTheMethodsApart) {
  const auto rows = compare({task("wall"), task("sphere"), task("torus"), task("stick_slip")},
                            {method("none"), method("per_axis"), method("contact_frame")}, {});
  ASSERT_EQ(rows.size(), 16u);
  EXPECT_GT(row(rows, "wall", "none").oscillation, 10 * kFelt);
  EXPECT_GT(row(rows, "wall", "none").energy_made, 0.05);
  EXPECT_LT(row(rows, "wall", "contact_frame").oscillation, kFelt);
  EXPECT_GT(row(rows, "sphere", "per_axis").direction_error, 40 * kDegree);
  EXPECT_GT(row(rows, "torus", "per_axis").direction_error, 40 * kDegree);
  for (const char* t : {"wall", "sphere", "torus"})
    EXPECT_LT(row(rows, t, "contact_frame").direction_error, 1e-6) << t;
  for (const CompareRow& r : rows) {
    EXPECT_GT(r.cost, 0.0);
    if (r.method == "contact_frame") {
      EXPECT_LT(r.energy_made, 1e-12) << r.task;
      // 2 b / T relative to the wall's 40 kN/m and the other objects' 5 kN/m
      EXPECT_NEAR(r.displayed, r.task == "wall" ? 0.025 : 0.2, r.task == "wall" ? 0.005 : 0.05)
          << r.task;
    }
    if (r.method == kReference) {
      EXPECT_LT(r.oscillation, kFelt) << r.task;
      EXPECT_NEAR(r.displayed, 1.0, 0.01) << r.task;
    }
  }
}

TEST(Compare, DelayOscillatesWithoutABoundOnly) {
  const auto rows =
      compare({task("stick_slip")}, {method("none"), method("contact_frame")}, {2.0, 1000.0, 5e-3});
  EXPECT_GT(row(rows, "stick_slip", "none").oscillation, 50 * kFelt);
  EXPECT_LT(row(rows, "stick_slip", "contact_frame").oscillation, kFelt);
}

// All bounds have errors of some tens of micrometres on a soft torus, because the bumps sink in.
TEST(Compare, ASofterTorusLetsItsBumpsIn) {
  CompareTask stiff = task("torus"), soft = stiff;
  soft.touch = [](const Tool& tool) {
    return penalty(torus_distance(BumpyTorus{}, tool.position), 1000.0);
  };
  const auto rows = compare({stiff, soft}, {}, {});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_GT(rows[1].oscillation, 2.0 * rows[0].oscillation);
}

/// Returns the number of threads of this process.
std::ptrdiff_t threads() {
  const std::filesystem::directory_iterator all("/proc/self/task"), end;
  return std::distance(all, end);
}

// The cost of a step must be measured without other runs. Otherwise it would depend on the
// machine's load.
TEST(Compare, EveryCostIsMeasuredAlone) {
  const std::vector<CompareTask> tasks = {task("tap"), task("edge")};
  const std::vector<Method> both = {method("none"), method("contact_frame")};
  const std::ptrdiff_t alone = threads();
  const auto caller = std::this_thread::get_id();
  std::vector<std::string_view> measured;
  const auto rows =
      compare(tasks, both, {}, [&](const auto& samples, const ExperimentSetup& setup) {
        EXPECT_EQ(threads(), alone);
        EXPECT_EQ(std::this_thread::get_id(), caller);
        EXPECT_FALSE(samples.empty());
        measured.push_back(setup.bounding.mode);
        return static_cast<double>(measured.size());
      });
  EXPECT_EQ(measured, (std::vector<std::string_view>{"none", "none", "contact_frame", "none",
                                                     "none", "contact_frame"}));
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_EQ(rows[i].cost, static_cast<double>(i + 1)) << rows[i].method;
}

// The rows for one hand and for eight hands come from equal runs.
TEST(Compare, OverEightHandsTheMedianAndTheWorst) {
  const std::vector<CompareTask> wall = {task("wall")};
  const std::vector<Method> one = {method("none")};
  std::vector<double> oscillations;
  for (const NamedHand& hand : kEightHands) {
    CompareLoop loop;
    loop.hand = hand.hand;
    oscillations.push_back(row(compare(wall, one, loop), "wall", "none").oscillation);
  }
  const auto rows = compare_hands(wall, one, {});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].worst_oscillation, std::ranges::max(oscillations));
  EXPECT_GT(rows[0].worst_oscillation, 2.0 * oscillations[0]) << "one hand tells too little";
  std::sort(oscillations.begin(), oscillations.end());
  EXPECT_EQ(rows[0].oscillation, 0.5 * (oscillations[3] + oscillations[4]));
  EXPECT_LE(rows[0].least_displayed, rows[0].displayed);
}

TEST(Compare, RefusesALoopThatCannotBeRun) {
  const std::vector<CompareTask> tasks = {task("tap")};
  const std::vector<Method> one = {method("none")};
  EXPECT_THROW(compare(tasks, one, {.rate = 0.0}), std::invalid_argument);
  EXPECT_THROW(compare(tasks, one, {.delay = -1e-3}), std::invalid_argument);
  EXPECT_THROW(compare_hands(tasks, one, {.delay = -1e-3}), std::invalid_argument);
  EXPECT_THROW(compare(tasks, one, {.damping = -1.0}), std::invalid_argument);
}

TEST(Compare, WritesEveryTaskByEveryMethodAndTheSameBytesEveryTime) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_compare_test";
  std::filesystem::remove_all(directory);
  const auto [rows, hands] = write_compare(directory, {});
  const std::string json = text_of(directory / "compare.json");
  const std::string csv = text_of(directory / "compare.csv");
  EXPECT_EQ(nlohmann::json::parse(json)["rows"].size(), 7u * (methods().size() + 1));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), static_cast<std::ptrdiff_t>(rows.size() + 1));
  ASSERT_EQ(hands.size(), 7u * methods().size());
  const std::string hands_csv = text_of(directory / "compare_hands.csv");
  EXPECT_EQ(std::count(hands_csv.begin(), hands_csv.end(), '\n'),
            static_cast<std::ptrdiff_t>(hands.size() + 1));
  EXPECT_NE(compare_hands_table(hands).find("stick_slip"), std::string::npos);
  const std::string cost = text_of(directory / "compare_cost.csv");
  EXPECT_EQ(std::count(cost.begin(), cost.end(), '\n'),
            static_cast<std::ptrdiff_t>(rows.size() + 1));
  EXPECT_GT(std::filesystem::file_size(directory / "compare.png"), 20000u);
  write_compare(directory, {});
  EXPECT_EQ(text_of(directory / "compare.json"), json);
  EXPECT_EQ(text_of(directory / "compare.csv"), csv);
  EXPECT_NE(compare_table(rows).find("stick_slip"), std::string::npos);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::compare_test
