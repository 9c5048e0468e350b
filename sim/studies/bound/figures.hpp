#pragma once
// The paper's Figures 2, 3, 5 and 6, reproduced on a simulated hand.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/measure/experiment_metrics.hpp"

namespace feltwire {

/// The modes that are run: no bound, the paper's methods and ours. The last has the device's
/// account after it, as in a session.
inline constexpr std::array<std::string_view, 6> kFigureModes = {
    kUnbounded, "total_energy", "per_axis", "per_axis_projected", kDefaultMethod, kSessionMethod};

/// A run of the paper's wall (Figures 2 and 3) or sphere (5 and 6).
struct FigureRun {
  std::string experiment;  // "wall" or "sphere"
  std::string_view mode = kUnbounded;
  double damping = 0.0;  // b [N s/m] of the device
  std::vector<ExperimentSample> samples;
  ExperimentMetrics metrics;
};

/// The common part of the runs: bounding.md's device, hand and movement.
/// Wall: 40 kN/m, 10 N s/m viscous along it, normal +y, slid over by +-30 mm at 0.5 Hz. Sphere: r =
/// 90 mm, 5 kN/m, glided round in the x-y plane.
ExperimentSetup figure_setup(const std::string& experiment, std::string_view mode, double damping,
                             Projection projection = Projection::joint);
FigureRun run_figure(const std::string& experiment, std::string_view mode, double damping);

/// Runs every mode at every damping and writes figures.json, a CSV a run and the pictures to
/// `directory` (created). Throws std::runtime_error when something cannot be written or drawn.
/// Returns the runs without their samples.
std::vector<FigureRun> write_figures(const std::filesystem::path& directory);

/// The runs as a table for people.
std::string figures_table(const std::vector<FigureRun>& runs);

}  // namespace feltwire
