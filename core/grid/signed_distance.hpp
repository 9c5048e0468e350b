#pragma once
// How far a point is from a shape's surface, anywhere: exact for the analytic solids, of the grid
// for a grid.

#include "core/geometry/shapes.hpp"
#include "core/grid/distance_grid.hpp"

namespace feltwire {

/// Signed distance of a position [m, object frame] to the shape felt from `side`: above zero where
/// it is free. Where several points of the surface are nearest the gradient is that of one of them.
/// Never allocates.
FieldPoint signed_distance(const Shape& shape, Side side, const Vec3& position) noexcept;

/// [m] A number that the signed distance is not below, where that is enough to know, `wanted`, at
/// the least cost (DistanceGrid::at_least).
double distance_at_least(const Shape& shape, Side side, const Vec3& position,
                         double wanted) noexcept;

/// Both of eight places [m, object frame], for less than one after the other where the shape is a
/// grid; the second fills in the distances alone.
void signed_distance(const Shape& shape, Side side, FieldGroup& group) noexcept;
void distance_at_least(const Shape& shape, Side side, FieldGroup& group,
                       const FieldGroup::Lanes& wanted) noexcept;

/// A shape as something to sample. The shape is copied. Throws std::invalid_argument for a plane,
/// which has no bounds.
Solid solid_of(const Shape& shape);

}  // namespace feltwire
