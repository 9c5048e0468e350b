#pragma once
// A closed mesh as convex parts: their number, the time of the cut, and the time of a tick of a
// body that collides by them.

#include <optional>
#include <string>
#include <vector>

#include "core/convex/decomposition.hpp"

namespace feltwire {

/// Cuts every triangle into four, `times` times. A new corner lies on the curve that the normals
/// define (Boubekeur & Alexa 2008, Phong tessellation), so that a body of a few thousand triangles
/// gets as many triangles as a scan.
TriangleMesh refined(const TriangleMesh& mesh, int times);

/// [us] of CPU of a tick, the median over a second.
struct TickCost {
  double on_floor = 0.0;  // a body of the mesh rests on a plane
  double on_like = 0.0;   // it rests on a static one like it; it can only move up and down
};

struct MeshParts {
  DecompositionOptions options;
  ConvexParts parts;
  std::size_t corners = 0;  // of all parts
  double volume = 0.0;      // of all parts, overlaps counted twice, over that of the mesh
  double wall = 0.0;        // [s] time of the cut
  double cpu = 0.0;         // [s] the same, of all threads
  TickCost tick;
};

/// Cuts the mesh once for each of the options and measures. Throws std::invalid_argument if the
/// mesh is not closed or its normals point inwards.
std::vector<MeshParts> measure_parts(const TriangleMesh& mesh,
                                     const std::vector<DecompositionOptions>& options);

/// For people.
std::string parts_table(const TriangleMesh& mesh, const std::vector<MeshParts>& rows);

}  // namespace feltwire
