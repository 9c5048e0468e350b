#pragma once

#include <filesystem>
#include <string>

#include "sim/studies/bound/figures.hpp"

namespace feltwire {

/// "wall_b0.5": the runs that differ in mode only.
std::string run_group(const FigureRun& run);
/// "wall_b0.5_per_axis": the stem of a run's CSV.
std::string run_name(const FigureRun& run);

/// Draws figure2, 3, 5 and 6.png in the paper's form, and sphere_modes.png and summary.png with all
/// modes side by side, from the CSVs of `runs` that stand in `directory`. Throws
/// std::runtime_error.
void draw_figures(const std::filesystem::path& directory, const std::vector<FigureRun>& runs);

}  // namespace feltwire
