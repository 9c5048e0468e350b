#pragma once
// The triangles that draw an object.

#include "core/geometry/triangle_soup.hpp"
#include "core/scene/scene.hpp"

namespace feltwire::web {

/// [m] half the side of the square that is drawn of a plane.
inline constexpr double kPlaneView = 0.2;
TriangleSoup plane_square();
/// The place of that square: around the point of the plane that is nearest to the scene's start.
Pose square_pose(const Pose& plane, const Vec3& start);

/// The triangles of a shape in its own frame; empty if it is unbounded. Allocates, and may take
/// some 10 ms.
TriangleSoup triangles_of(const Shape& shape);
/// The triangles of a guide whose place is a shape, in the place's frame, with fewer steps; of a
/// plane its square. Empty for other places.
TriangleSoup triangles_of_place(const GuidePlace& place);

}  // namespace feltwire::web
