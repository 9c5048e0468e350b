#pragma once
// A ball as an analytic solid, as meshes and as grids of distances: the error, time and memory of
// each.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// The measured cells. A ball of radius 90 mm and 5 kN/m; a probe 2 mm inside glides once round it
/// on a tilted circle at 0.1 m/s, sampled at 1 kHz.
struct GeometryGrid {
  std::vector<int> levels = {3, 5, 7, 8};  // icospheres of 20 * 4^level triangles
  std::vector<double> resolutions = {4e-3, 2e-3, 1e-3, 0.5e-3};  // [m]
};

struct GeometryCell {
  std::string
      kind;  // "analytic", "mesh, nearest", "mesh, proxy", "grid, linear", "grid, quadratic"
  std::string arithmetic;  // "float", "double"; of a proxy: corners and tool as float has them
  double size = 0.0;       // triangles, or [m] between samples
  // Equal in every run.
  double direction_error = 0.0, worst_direction = 0.0;  // [rad] mean and largest
  double force_error = 0.0;  // RMS of the force less the ball's, over the RMS of the ball's
  double jump = 0.0;         // [N] largest change from one sample to the next, less the ball's own
  // Depends on this machine.
  double glide_ns = 0.0;      // [ns] a query along the path
  double scattered_ns = 0.0;  // [ns] a query at places far from each other, 2 mm inside; of a
                              // proxy: its first
  double bytes = 0.0;         // memory
  double build = 0.0;         // [s] of all threads' CPU time together
};

/// Every cell: the solid, meshes (nearest point by the tree, signed; the proxy of contact),
/// grids by interpolation, arithmetic and resolution.
std::vector<GeometryCell> run_trade_geometry(const GeometryGrid& grid);

/// Writes trade_geometry.csv, .json and .png, the same bytes every time, and apart from them the
/// times on this machine: trade_geometry_cost.csv and .png. `directory` is created. Throws
/// std::runtime_error if something cannot be written or drawn.
void write_trade_geometry(const std::filesystem::path& directory,
                          const std::vector<GeometryCell>& cells);

/// All results for people.
std::string trade_geometry_table(const std::vector<GeometryCell>& cells);

}  // namespace feltwire
