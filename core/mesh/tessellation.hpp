#pragma once
// Analytic solids as triangles. The points of a tool are taken from them, and tests compare meshes
// with them.

#include "core/geometry/shapes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// A sphere of `radius` [m] about the origin: an icosahedron whose triangles are cut into four
/// `level` times. All corners lie on the sphere. It has 20 * 4^level triangles.
TriangleSoup icosphere(double radius, int level);

/// The surface of a shape in its own frame, closed, with its normals outwards. A round side becomes
/// `segments` (at least 3) flat ones with their corners on the surface. Boxes are exact. Throws
/// std::invalid_argument for a plane and a grid, which have no finite surface to cut up.
TriangleSoup tessellate(const Shape& shape, int segments);

}  // namespace feltwire
