#pragma once
// The triangles that draw an object.

#include "core/geometry/triangle_soup.hpp"
#include "core/scene/scene.hpp"

namespace feltwire::web {

/// [m] size of the drawn part of a plane, about its point.
inline constexpr double kPlaneView = 0.2;

/// The triangles of a shape in its own frame; empty if it is unbounded. Allocates, and may take
/// some 10 ms.
TriangleSoup triangles_of(const Shape& shape);

}  // namespace feltwire::web
