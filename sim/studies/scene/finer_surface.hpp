#pragma once
// A closed surface with more triangles.

#include <cstddef>

#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// Returns the surface with at least so many triangles: its longest edges are halved, all of them
/// as often as that takes. A new vertex lies on the curve that leaves both ends at right angles to
/// their normals, in the middle (Vlachos et al. 2001, Curved PN triangles), so that the surface
/// gets smoother. It stays closed. The same surface gives the same bits.
TriangleSoup finer_surface(TriangleSoup surface, std::size_t triangles);

}  // namespace feltwire
