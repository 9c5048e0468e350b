#pragma once
// The place to which a point inside a shape is pushed out.

#include "core/base/work_limit.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

/// The proxy of a point [m, object frame] against a shape felt from `side`. Contact is local
/// (Zilles & Salisbury's god-object): the proxy stays on the flat face through which the point came
/// in, even where one step leads through the whole solid. It stays there while the straight way
/// back to the face leads through the solid, however thin that is; that is, until the point is in
/// front of the face again, or beside it. On a round surface the proxy follows the point; where the
/// point is pressed through the middle, the proxy stays behind (round_proxy.hpp). A free point
/// gives depth 0, and the memory keeps no more than its position.
///
/// A grid remembers no face: depth times normal is -d grad d of its distance d. This force has a
/// potential and falls to zero where two surfaces are equally near. So a hand is pushed through a
/// part of a grid that is thinner than twice the hand's depth.
///
/// Only a mesh costs more than a few units of `work`. Where it is cut off, the memory stays as it
/// was and the result means nothing.
SurfacePoint surface_point(const Shape& shape, Side side, const Vec3& position,
                           FeatureMemory& memory, WorkLimit* work = nullptr) noexcept;

/// Whether the memory of this shape keeps the position of a free point. A mesh's memory does, and
/// that of every solid with a far side.
bool follows_way(const Shape& shape, Side side) noexcept;
/// The origin of FeatureMemory::proxy [m, object frame].
Vec3 origin_of(const Shape& shape) noexcept;
/// Seeds the memory of a shape that was not evaluated in the sample before: the tool was at
/// `position` then [m, object frame].
void approach_from(const Shape& shape, const Vec3& position, FeatureMemory& memory) noexcept;

}  // namespace feltwire
