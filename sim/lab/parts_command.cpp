// feltwire-lab parts: a mesh as the convex parts that bodies run into.

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh/mesh_file.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/studies/scene/mesh_parts.hpp"

namespace feltwire {
namespace {

struct PartsOptions {
  std::string mesh;
  double scale = 1.0;
  std::vector<double> tolerances;
  std::size_t most = DecompositionOptions{}.most;
  int refine = 0;
};

/// Of each tolerance, behind one hull of the whole.
std::vector<DecompositionOptions> rows_of(const PartsOptions& given, double size) {
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

void run_parts(const PartsOptions& given) {
  TriangleMesh mesh(read_mesh(given.mesh, given.scale));
  if (mesh.report().closed() && mesh.report().volume < 0.0) mesh.turn();
  mesh = refined(mesh, given.refine);
  std::cout << given.mesh << ": "
            << parts_table(mesh, measure_parts(mesh, rows_of(given, mesh.report().size)));
}

}  // namespace

void add_parts(CLI::App& app) {
  constexpr int kMostRefined = 4;
  constexpr double kMostScale = 1e6;
  auto o = std::make_shared<PartsOptions>();
  CLI::App* command = app.add_subcommand(
      "parts", "Cut a closed mesh into the convex parts that bodies run into, and measure them");
  command->footer(
      "Prints how many parts there are, how far they reach out of the mesh, what cutting took, and "
      "what a tick of a\nbody costs that collides by them; the first row is one hull of the whole. "
      "docs/moving.md says what scenes do\nwith parts. Example:\n"
      "  feltwire-lab parts scenes/bunny.obj --scale 0.01 --tolerance 0.004,0.002,0.001");
  command->add_option("mesh", o->mesh, "The file: OBJ, STL or PLY")->required();
  command->add_option("--scale", o->scale, "[m] of a unit of the file")
      ->check(CLI::Range(1e-6, kMostScale))
      ->capture_default_str();
  command
      ->add_option("--tolerance", o->tolerances,
                   "[m] that a part may reach out, one row each; default 2 % of the longest side")
      ->delimiter(',');
  command->add_option("--most", o->most, "Parts at most")
      ->check(CLI::Range(std::size_t{1}, kMostParts))
      ->capture_default_str();
  command
      ->add_option("--refine", o->refine,
                   "Cut each triangle into four, so many times, bent as the normals say")
      ->check(CLI::Range(0, kMostRefined))
      ->capture_default_str();
  command->callback([o] { run_parts(*o); });
}

}  // namespace feltwire
