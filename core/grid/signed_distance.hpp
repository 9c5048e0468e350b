#pragma once
// The distance of any point from a shape's surface: exact for analytic solids, interpolated for
// grids.

#include "core/geometry/shapes.hpp"
#include "core/grid/distance_grid.hpp"

namespace feltwire {

/// Signed distance [m] of a position [m, object frame] to the shape felt from `side`; above zero if
/// the position is free. If several points of the surface are equally near, the gradient is that of
/// one of them. Never allocates.
FieldPoint signed_distance(const Shape& shape, Side side, const Vec3& position) noexcept;

/// [m] A lower bound of the signed distance. It costs least if it is `wanted` or more
/// (DistanceGrid::at_least).
double distance_at_least(const Shape& shape, Side side, const Vec3& position,
                         double wanted) noexcept;

/// Both for eight places [m, object frame]. For a grid this costs less than one place after the
/// other. The second fills in the distances only.
void signed_distance(const Shape& shape, Side side, FieldGroup& group) noexcept;
void distance_at_least(const Shape& shape, Side side, FieldGroup& group,
                       const FieldGroup::Lanes& wanted) noexcept;

/// A shape as a solid that a grid can sample. The shape is copied. Throws std::invalid_argument for
/// a plane, which has no bounds.
Solid solid_of(const Shape& shape);

}  // namespace feltwire
