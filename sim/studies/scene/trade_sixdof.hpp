#pragma once
// A body in the hand: by points or by polygons, each without mass and with mass. Error, jumps,
// time, memory, stability.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/measure/stiffness_search.hpp"

namespace feltwire {

/// The size of the study: how finely it measures.
struct SixDofGrid {
  std::vector<std::string> tasks{};    // those of sixdof_tasks.hpp with these names; empty: all
  std::size_t points = 3000;           // on a tool of points
  double grid_steps = 128.0;           // along a mesh that a tool of points touches; as in a scene
  int finer = 8;                       // of the reference, below; even
  double slower = 1.0;                 // of the hand in all tasks: their time is that much longer
  double bunny_tolerance = 2e-3;       // [m] of its convex parts
  std::size_t fine_triangles = 20000;  // of the task "bunny 20k"; 0: without it
  std::size_t cost_laps = 3;           // of each task, for the times
  double hand_time = 0.4;              // [s] of a hand that leans on the tool, for each stiffness
  StiffnessRange stiffness{.lowest = 1000.0, .highest = 1e6, .per_decade = 4, .tolerance = 0.1};
};

/// A task of sixdof_tasks.hpp by one contact, with or without mass, at 1 kHz. Material and coupling
/// have 1 kN/m. A tool with mass has 0.1 kg, goes by backward Euler, of polygons also by the
/// midpoint rule, and is critically damped on its coupling.
///
/// The reference is the same law, finer: with mass so many points and steps in each of 1 ms;
/// without mass twice as many points, a quarter of the steps, and each step is repeated until the
/// tool stands. The grid of a mesh is finer by the square root of the points. The reference's own
/// error is the change when it is made half as fine.
struct SixDofCell {
  /// MuJoCo's rows ("mujoco", "euler"): mj_step() with the same tool with mass, parts and coupling.
  /// Its contact has another law, so that its errors, against the reference of polygons with mass,
  /// contain the difference of the laws. It has no `stable`.
  std::string task, contact, mass;  // "points" or "polygons"; "none", "implicit", "midpoint"
  /// RMS over the RMS of the reference's force; that of the torque over the tool's radius, too.
  double force_error = 0.0, torque_error = 0.0;
  double reference_force_error = 0.0, reference_torque_error = 0.0;
  double largest_force = 0.0;   // [N]
  double jump = 0.0;            // [N] largest change of the force from one sample to the next
  double reference_jump = 0.0;  // [N] the same at the reference's samples of the same times
  double median_ns = 0.0, p99_9_ns = 0.0;  // [ns] of CPU time, of this machine
  std::size_t bytes = 0;                   // of what the contact reads: shell and grid, or parts
  /// [N/m] A device of 50 g with 2 N s/m, sampled at 1 kHz, moves along one line and leans on the
  /// tool with 0.25 N: the largest stiffness of material and coupling at which it comes to rest;
  /// the coupling is not damped.
  StiffnessLimit stable;
};

std::vector<SixDofCell> run_trade_sixdof(const SixDofGrid& grid);

/// Writes trade_sixdof.csv and trade_sixdof.json, the same bytes every time, and apart from them
/// the times on this machine: trade_sixdof_cost.csv. `directory` is created. Throws
/// std::runtime_error if something cannot be written.
void write_trade_sixdof(const std::filesystem::path& directory,
                        const std::vector<SixDofCell>& cells);

/// All results for people.
std::string trade_sixdof_table(const std::vector<SixDofCell>& cells);

}  // namespace feltwire
