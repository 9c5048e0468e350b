#pragma once
// Where a point inside any shape is pushed out.

#include "core/geometry/shapes.hpp"

namespace feltwire {

/// The proxy of a point [m, object frame] against a shape felt from `side`. Contact is local
/// (Zilles & Salisbury's god-object): a proxy stays on the flat face that the way of the point went
/// in by, also where one step goes through the whole solid. It stays until the point is in front of
/// that face again, or beside it: as long as the way straight back to the face leads through the
/// solid, however thin that is. On what is round it follows the point, and stays behind where that
/// is pressed through the middle (round_proxy.hpp). Free points give depth 0 and remember no more
/// than where they are. A grid remembers no face: its depth times normal is -d grad d of its
/// distance d, a force with a potential, which falls to zero where two surfaces are equally near. A
/// hand is pushed through what is thinner than twice its depth in the grid.
SurfacePoint surface_point(const Shape& shape, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;

/// Whether the memory of this shape keeps the position of a free point: that of a mesh does, and
/// that of each solid that has a far side.
bool follows_way(const Shape& shape, Side side) noexcept;
/// The origin of FeatureMemory::proxy [m, object frame].
Vec3 origin_of(const Shape& shape) noexcept;
/// Seeds the memory of a shape that was not asked in the sample before: the tool was at `position`
/// then [m, object frame].
void approach_from(const Shape& shape, const Vec3& position, FeatureMemory& memory) noexcept;

}  // namespace feltwire
