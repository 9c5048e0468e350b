#pragma once
// The parts of an object's surface near a point. One SurfacePatch describes one part exactly.

#include <cstdint>

#include "core/contact/contact.hpp"
#include "core/local_model/local_model.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"

namespace feltwire {

/// All parts of an analytic shape's surface. A mesh or a grid has none: its patches are fitted
/// (fitted_patches.hpp). `position` [m, object frame]; `entered` is the feature that a tool there
/// touches, 0: none. `ball` [m]: the radius of the tool, which meets a part earlier; 0: a point.
///
/// For every R: all parts with distance < R together make up the whole shape within R of the
/// position. There is one exception: a tool that enters nearer to R than it is deep may enter by
/// another of two convex faces.
SurfaceParts surface_parts(const Shape& shape, Side side, const Vec3& position,
                           std::uint32_t entered, double ball) noexcept;

/// The visible part of that feature as a patch in the world frame, at its point nearest to
/// `position` [m, world]. Radius and object are 0; the caller sets them. Of a solid that grows with
/// the ball it is a part of the grown one; all others get an offset.
SurfacePatch surface_patch(const Object& object, const Vec3& position, std::uint32_t feature,
                           const ContactMemory& memory, double ball) noexcept;

/// As above, for a fitted patch.
SurfacePatch surface_patch(const Object& object, const FittedPatches& fitted, int index,
                           const ContactMemory& memory) noexcept;

/// Tells a patch what a tool remembers that touches it.
void set_touched(SurfacePatch& patch, const Object& object, const ContactMemory& memory) noexcept;

}  // namespace feltwire
