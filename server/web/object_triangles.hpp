#pragma once
// The triangles that an object is drawn with.

#include "core/geometry/triangle_soup.hpp"
#include "core/scene/scene.hpp"

namespace feltwire::web {

/// [m] of a plane that is worth looking at, about its point.
inline constexpr double kPlaneView = 0.2;

/// The triangles of a shape in its own frame; none where it has no end. Allocates, and may take
/// some 10 ms.
TriangleSoup triangles_of(const Shape& shape);

}  // namespace feltwire::web
