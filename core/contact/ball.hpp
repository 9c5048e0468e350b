#pragma once
// A tool that is a ball instead of a point.

#include "core/contact/surface_point.hpp"

namespace feltwire {

/// Where a ball of `radius` [m], > 0, about a position [m, object frame] stands on a shape felt
/// from `side`: the nearest point of the surface, its normal, and how deep the ball is in it. What
/// of a solid stays of its kind when it grows by the radius (plane, sphere, capsule, hollow box and
/// cylinder) is that solid to the centre; boxes and cylinders get round edges, and the face that
/// the ball entered by is remembered where its centre is in the solid. On a mesh the point is where
/// the centre is held, as on one that has the radius itself; to that of the mesh it is added. Free:
/// depth 0, memory cleared (a mesh remembers the way). Precondition: a hollow has room for the
/// ball; a grid's band is no less than the radius.
SurfacePoint ball_surface(const Shape& shape, Side side, const Vec3& position, double radius,
                          FeatureMemory& memory) noexcept;

/// Whether a ball has room in a hollow, and a grid its distances within the ball's radius.
bool ball_fits(const Shape& shape, Side side, double radius) noexcept;

}  // namespace feltwire
