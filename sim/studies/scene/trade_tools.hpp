#pragma once
// The number of points on a tool's body: the error of force and torque, and the time of a step.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// The measured numbers of points, and that of the reference.
struct ToolsGrid {
  std::vector<std::size_t> points = {100, 300, 1000, 3000, 10'000, 30'000, 100'000};
  std::size_t reference = 1'000'000;
  int poses = 64;   // a task's, over which errors are taken
  int steps = 400;  // of a moving hand, over which time is taken
};

/// Tasks, each of a body against a grid of distances of 1 kN/m:
///   flat  a box of 60 x 40 x 20 mm lies 1 mm deep on a plate
///   edge  the same box stands on its edge, turned by 30 degrees, 2 mm deep
///   peg   a rod of 10 mm radius in a hole of 10.2 mm, tilted by 2 degrees and pressed to the side
struct ToolsCell {
  std::string task;
  std::size_t points = 0;
  // Equal in every run.
  double force_error = 0.0;   // RMS of the force less the reference's, over the RMS of the latter
  double torque_error = 0.0;  // RMS of the torque less the reference's, over the RMS of the
                              // reference's force times the body's radius
  double looked_at = 0.0;     // nodes and points whose distance was computed, mean over the poses
  double touching = 0.0;      // points inside, mean over the poses
  // Depends on this machine: a step of the coupled tool [ns], mean over a moving hand's steps.
  double far_ns = 0.0;       // 0.1 m away
  double contact_ns = 0.0;   // in the task
  double evaluations = 0.0;  // of all contacts in such a step (the same in every run)
};

/// Every cell, points fastest.
std::vector<ToolsCell> run_trade_tools(const ToolsGrid& grid);

/// Writes trade_tools.csv, .json and .png, the same bytes every time, and apart from them the times
/// on this machine: trade_tools_cost.csv and .png. `directory` is created. Throws
/// std::runtime_error if something cannot be written or drawn.
void write_trade_tools(const std::filesystem::path& directory, const std::vector<ToolsCell>& cells);

/// All results for people.
std::string trade_tools_table(const std::vector<ToolsCell>& cells);

}  // namespace feltwire
