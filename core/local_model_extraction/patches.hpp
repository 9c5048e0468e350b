#pragma once
// An object's surface near a point, in parts that one SurfacePatch describes exactly.

#include <cstdint>

#include "core/contact/contact.hpp"
#include "core/local_model/local_model.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"

namespace feltwire {

/// All parts of an analytic shape's surface; none of a mesh or a grid, whose patches are fitted
/// (fitted_patches.hpp). `position` [m, object frame]; `entered` is the feature that a
/// tool there stands on, 0: none.
///
/// For every R: within R of the position, the shape is what the parts with distance < R make of it,
/// if all of these are shown. Only which of two convex faces a tool enters by may differ where it
/// enters nearer to R than it is deep.
SurfaceParts surface_parts(const Shape& shape, Side side, const Vec3& position,
                           std::uint32_t entered) noexcept;

/// The shown part of that feature as a patch in the world frame, at its point nearest to `position`
/// [m, world], with radius 0 and object 0: these are the caller's to say.
SurfacePatch surface_patch(const Object& object, const Vec3& position, std::uint32_t feature,
                           const ContactMemory& memory) noexcept;

/// The same of a fitted patch.
SurfacePatch surface_patch(const Object& object, const FittedPatches& fitted, int index,
                           const ContactMemory& memory) noexcept;

}  // namespace feltwire
