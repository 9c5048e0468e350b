#pragma once
// How far a convex polyhedron reaches out of a solid.

#include "core/convex/convex_hull.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// [m] The largest distance of a point of the hull from the solid that a closed mesh bounds, in the
/// mesh's coordinates (relative to its origin). It is found by boxes that are cut in two: as the
/// distance changes by no more than the way between two points, a box whose middle is far enough
/// inside is done (Piyavskii 1972, Shubert 1972). The result is the largest distance that was
/// found. No point is farther out than 9/8 of that, or than `tolerance` if that is more.
/// Precondition: tolerance > 0; the surface is closed with its normals outwards.
double overhang(const ConvexHull& hull, const MeshSurface& solid, double tolerance);

}  // namespace feltwire
