// The command feltwire-lab convex-parts. It splits a mesh into convex parts, which bodies use for
// collisions.

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/visible_text.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/studies/scene/mesh_parts.hpp"

namespace feltwire {
namespace {

struct ConvexPartsOptions {
  std::string mesh;
  double scale = 1.0;
  std::vector<double> tolerances;
  std::size_t most = DecompositionOptions{}.most;
  int refine = 0;
};

/// Returns the options for each row of the table. The first row is a single convex hull of the
/// mesh. Then each tolerance has a row.
std::vector<DecompositionOptions> rows_of(const ConvexPartsOptions& given, double size) {
  std::vector<DecompositionOptions> rows{{.most = 1}};
  for (const double tolerance : given.tolerances) {
    if (!(tolerance >= kLeastPartTolerance * size && tolerance <= size))
      throw std::invalid_argument("--tolerance: must be " + std::to_string(kLeastPartTolerance) +
                                  " to 1 of the longest side, " + std::to_string(size) + " m");
    rows.push_back({.tolerance = tolerance, .most = given.most});
  }
  if (given.tolerances.empty()) rows.push_back({.most = given.most});
  return rows;
}

void run_convex_parts(const ConvexPartsOptions& given) {
  TriangleMesh mesh(read_mesh(given.mesh, given.scale), {}, true);
  if (mesh.report().closed() && mesh.report().volume < 0.0) mesh.turn();
  mesh = refined(mesh, given.refine);
  std::cout << visible(given.mesh) << ": "
            << parts_table(mesh, measure_parts(mesh, rows_of(given, mesh.report().size)));
}

}  // namespace

void add_convex_parts(CLI::App& app) {
  constexpr int kMostRefined = 4;
  constexpr double kMostScale = 1e6;
  auto o = std::make_shared<ConvexPartsOptions>();
  CLI::App* command = app.add_subcommand(
      "convex-parts",
      "Cut a closed mesh into the convex parts that bodies collide with, and measure them");
  command->footer(
      "Prints the number of parts, their largest distance outside the mesh, the time of the\n"
      "decomposition, and the time of a tick of a body with these parts. The first row is one\n"
      "hull of the whole mesh. docs/moving.md explains how scenes use parts. Example:\n"
      "  feltwire-lab convex-parts scenes/bunny.obj --scale 0.01 --tolerance 0.004,0.002,0.001");
  command->add_option("mesh", o->mesh, "Mesh file: OBJ, STL or PLY")->required();
  command->add_option("--scale", o->scale, "[m] Length of one unit of the file")
      ->check(CLI::Range(1e-6, kMostScale))
      ->capture_default_str();
  command
      ->add_option("--tolerance", o->tolerances,
                   "[m] Largest distance by which a part may exceed the mesh. Each value gives a "
                   "row. Default: 2 % of the longest side")
      ->delimiter(',');
  command->add_option("--most", o->most, "Largest number of parts")
      ->check(CLI::Range(std::size_t{1}, kMostParts))
      ->capture_default_str();
  command
      ->add_option("--refine", o->refine,
                   "Number of times to split each triangle into four, curved by the normals")
      ->check(CLI::Range(0, kMostRefined))
      ->capture_default_str();
  command->callback([o] { run_convex_parts(*o); });
}

}  // namespace feltwire
