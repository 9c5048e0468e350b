#pragma once
// Measures how far a convex polyhedron reaches out of a solid.

#include "core/convex/convex_hull.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// [m] The largest distance of a point of the hull from the solid that a closed mesh bounds, in the
/// mesh's coordinates (relative to its origin). The search halves boxes. The distance changes by no
/// more than the distance between two points, so a box whose middle is far enough inside needs no
/// further search (Piyavskii 1972, Shubert 1972). The result is the largest distance found. No
/// point is farther out than 9/8 of that, or than `tolerance` if that is more. Precondition:
/// tolerance > 0; the surface is closed with its normals outwards.
double outward_error(const ConvexHull& hull, const MeshSurface& solid, double tolerance);

}  // namespace feltwire
