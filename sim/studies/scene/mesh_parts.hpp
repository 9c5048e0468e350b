#pragma once
// A closed mesh as convex parts: how many there are, how long that takes, and what a tick of a body
// that collides by them costs.

#include <optional>
#include <string>
#include <vector>

#include "core/convex/decomposition.hpp"

namespace feltwire {

/// Every triangle cut into four, `times` times. A new corner lies where the surface bends as its
/// normals say (Boubekeur & Alexa 2008, Phong tessellation), so that a body of a few thousand
/// triangles becomes one of many with as much detail as a scan has.
TriangleMesh refined(const TriangleMesh& mesh, int times);

/// [us] of CPU of a tick, the median over a second.
struct TickCost {
  double on_floor = 0.0;  // a body of the mesh rests on a plane
  double on_like = 0.0;   // it rests on one like it that stands; it can only go up and down
};

struct MeshParts {
  DecompositionOptions options;
  ConvexParts parts;
  std::size_t corners = 0;  // of all parts
  double volume = 0.0;      // of all parts, overlaps counted twice, over that of the mesh
  double wall = 0.0;        // [s] that cutting took
  double cpu = 0.0;         // [s] likewise, of all threads
  TickCost tick;
};

/// Cuts the mesh once for each of the options and measures. Throws std::invalid_argument where the
/// mesh is not closed or its normals look inwards.
std::vector<MeshParts> measure_parts(const TriangleMesh& mesh,
                                     const std::vector<DecompositionOptions>& options);

/// For people.
std::string parts_table(const TriangleMesh& mesh, const std::vector<MeshParts>& rows);

}  // namespace feltwire
