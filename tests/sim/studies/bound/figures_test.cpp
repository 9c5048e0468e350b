// Tests the figures of the paper as numbers. The limits are wide around the measured values
// (docs/lab/figures.md). A method that stops working is far outside these limits.

#include "sim/studies/bound/figures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

namespace feltwire::figures_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMicrometre = 1e-6;

ExperimentMetrics measured(const char* experiment, std::string_view mode, double damping) {
  return run_figure(experiment, mode, damping).metrics;
}

TEST(Figures, Figure2TotalEnergyLetsTheStiffWallBuzz) {
  const auto none = run_figure("wall", "none", 0.5);
  const auto total = run_figure("wall", "total_energy", 0.5);
  EXPECT_GT(total.metrics.highpass_rms.y(), 100 * kMicrometre);
  EXPECT_GT(total.metrics.total_energy, 0.0) << "Eq. (1) holds all the same";
  // This method never acts. The run must equal the unbounded run bitwise.
  ASSERT_EQ(none.samples.size(), total.samples.size());
  for (std::size_t n = 0; n < none.samples.size(); ++n)
    ASSERT_EQ(none.samples[n].position, total.samples[n].position);
  // The exchanged energy of the port must show the vibration.
  EXPECT_LT(total.metrics.min_port_energy.y(), -0.1);
}

// Figure 2 of the paper shows this effect, and our figure uses this run. The port's total stays
// positive while y delivers energy and oscillates.
TEST(Figures, Figure2sTotalIsPositiveWhileYGivesEnergy) {
  const FigureRun run = run_figure("wall", "total_energy", 8.0);
  EXPECT_LT(run.metrics.highpass_rms.y(), 15 * kMicrometre) << "small";
  EXPECT_GT(run.metrics.highpass_rms.y(), 3 * kMicrometre) << "and there";
  Vec3 port = Vec3::Zero();
  for (const ExperimentSample& s : run.samples) {
    port -= s.held.cwiseProduct(s.displacement);
    if (s.time < 3.0) continue;  // before the range of the figure
    ASSERT_GT(port.sum(), 0.0) << s.time;
    ASSERT_LT(port.y(), 0.0) << s.time;
  }
}

TEST(Figures, TheDefaultOfSessionsIsCalmAndGivesTheWholeForce) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    const ExperimentMetrics m = measured("wall", "shaped", damping);
    EXPECT_LT(m.highpass_rms.y(), 10 * kMicrometre) << damping;
    EXPECT_GT(m.force_ratio, 0.95) << damping;
  }
}

TEST(Figures, Figure3PerAxisCalmsTheWall) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    const ExperimentMetrics m = measured("wall", "per_axis", damping);
    EXPECT_LT(m.highpass_rms.y(), 2 * kMicrometre) << damping;
    EXPECT_GT(m.min_energy.minCoeff(), -1e-12) << "Eq. (2), " << damping;
    EXPECT_EQ(m.outside_bounds_share, 0.0) << damping;
  }
}

TEST(Figures, ProjectionGivesBackWhatThePerAxisBoundTook) {
  const ExperimentMetrics m = measured("wall", "per_axis_projected", 2.0);
  EXPECT_GT(m.highpass_rms.y(), 20 * kMicrometre);
  EXPECT_GT(m.outside_bounds_share, 0.5);
}

TEST(Figures, ContactFrameCalmsTheWallAndKeepsItsDirection) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    const ExperimentMetrics m = measured("wall", "contact_frame", damping);
    EXPECT_LT(m.highpass_rms.y(), 5 * kMicrometre) << damping;
    EXPECT_LT(m.direction_error.max, 1e-6) << damping;
    EXPECT_GT(m.min_port_margin, -1e-12) << damping;
  }
}

TEST(Figures, Figure5PerAxisBendsTheForceOfASphere) {
  for (const double damping : {0.2, 0.5, 2.0})
    EXPECT_GT(measured("sphere", "per_axis", damping).direction_error.mean, 40 * kDegree)
        << damping;
}

TEST(Figures, Figure6ProjectionPointsAlongTheNormal) {
  for (const double damping : {0.2, 0.5, 2.0}) {
    const ExperimentMetrics m = measured("sphere", "per_axis_projected", damping);
    EXPECT_LT(m.direction_error.mean, 0.1 * kDegree) << damping;
    EXPECT_GT(m.outside_bounds_share, 0.5) << damping;
  }
}

TEST(Figures, ContactFrameGivesMoreOfTheSphereThanTheProjection) {
  for (const double damping : {0.2, 0.5, 2.0}) {
    const ExperimentMetrics contact = measured("sphere", "contact_frame", damping);
    EXPECT_LT(contact.direction_error.max, 1e-6) << damping;
    EXPECT_GT(contact.force_ratio, measured("sphere", "per_axis_projected", damping).force_ratio)
        << damping;
    EXPECT_GT(contact.min_port_margin, -1e-12) << damping;
  }
}

TEST(Figures, RunsAreDeterministic) {
  const auto a = run_figure("sphere", "contact_frame", 0.5);
  const auto b = run_figure("sphere", "contact_frame", 0.5);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t n = 0; n < a.samples.size(); ++n) {
    ASSERT_EQ(a.samples[n].position, b.samples[n].position);
    ASSERT_EQ(a.samples[n].rendered.force(), b.samples[n].rendered.force());
  }
}

TEST(Figures, WritesEveryFigureInEveryModeAtEveryDamping) {
  const std::filesystem::path directory =
      std::filesystem::path(::testing::TempDir()) / "feltwire_figures_test";
  std::filesystem::remove_all(directory);
  write_figures(directory);
  std::ifstream in(directory / "figures.json");
  const auto json = nlohmann::json::parse(in);
  ASSERT_EQ(json.size(), 4u * 6u * 3u);
  for (const int figure : {2, 3, 5, 6}) {
    // The modes are the paper's methods, the methods for comparison, and the defaults.
    for (const std::string_view mode : kFigureModes) {
      const auto count = std::count_if(json.begin(), json.end(), [&](const auto& e) {
        return e["figure"] == figure && e["mode"] == mode;
      });
      EXPECT_EQ(count, 3) << figure << " " << mode;
    }
    EXPECT_GT(std::filesystem::file_size(directory / ("figure" + std::to_string(figure) + ".png")),
              10000u);
  }
  for (const char* picture : {"sphere_modes.png", "summary.png"})
    EXPECT_GT(std::filesystem::file_size(directory / picture), 10000u) << picture;
  for (const auto& e : json) {
    EXPECT_EQ(e["highpass_rms_um"].size(), 3u);
    EXPECT_EQ(e["min_energy_j"].size(), 3u);
    for (const char* key : {"mean", "p99", "max"})
      EXPECT_TRUE(e["direction_error_deg"][key].is_number());
    for (const char* key : {"damping", "total_energy_j", "force_ratio", "outside_bounds_share"})
      EXPECT_TRUE(e[key].is_number()) << key;
  }
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::figures_test
