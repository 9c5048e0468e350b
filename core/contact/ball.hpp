#pragma once
// A tool that is a ball instead of a point.

#include "core/contact/surface_point.hpp"

namespace feltwire {

/// The contact of a ball with a shape felt from `side`: the place where its centre is held, the
/// surface's normal, and how deep the ball is in it. `radius` [m], > 0; `position` of its centre
/// [m, object frame]. The ball does not turn, so friction follows the movement of its centre.
///
/// Some solids keep their kind when they grow by the radius (Grown::round is zero): the centre
/// touches the grown solid. Boxes, cylinders and cones get round edges from outside; while the
/// centre is in the solid, the memory holds the face by which the ball entered. A mesh adds the
/// radius to its own. A free ball gives depth 0 and a cleared memory (a mesh remembers the path).
///
/// Precondition: a hollow has room for the ball; a grid's band is no less than the radius. `work`:
/// as in surface_point().
SurfacePoint ball_surface(const Shape& shape, Side side, const Vec3& position, double radius,
                          FeatureMemory& memory, WorkLimit* work = nullptr) noexcept;

/// Whether the precondition of ball_surface() holds.
bool ball_fits(const Shape& shape, Side side, double radius) noexcept;

}  // namespace feltwire
