#pragma once
// Analytic solids as triangles: what a tool's points are taken from, and what meshes are measured
// against.

#include "core/geometry/shapes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// A ball about the origin: an icosahedron whose triangles are quartered `level` times, all corners
/// on the sphere; 20 * 4^level triangles. radius [m].
TriangleSoup icosphere(double radius, int level);

/// The surface of a shape in its own frame, closed, outside out. Round sides have `segments` (at
/// least 3) flat ones, their corners on the surface; boxes are exact. Throws std::invalid_argument
/// for a plane and a grid, which have no surface of their own to cut up.
TriangleSoup tessellate(const Shape& shape, int segments);

}  // namespace feltwire
