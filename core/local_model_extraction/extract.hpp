#pragma once

#include <vector>

#include "core/dynamics/world.hpp"
#include "core/local_model/local_model.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// [m] The largest reach of a model. A hand at 1 m/s passes it in 0.1 s. By then a command of the
/// usual hold time has faded.
inline constexpr double kModelReach = 0.1;

/// Whether a receiver may have an object in full: one that is still, and for a point or a ball a
/// mesh that can_travel(), for a body of points a primitive or a mesh.
bool can_travel(const ToolView& view, std::size_t object) noexcept;

/// By object of the scene: the receiver has its whole surface (prefetched_geometry.hpp). Of objects
/// beyond the end it has none. Only objects that can_travel() may be in it.
using KnownSurfaces = std::vector<bool>;

/// The surfaces of the scene near a tool position [m, world]: first those that the tool touches,
/// then those that it would meet first. `memory`: the result of touch() at that position. All other
/// surfaces are farther away than the model's reach. If the tool touches more than kMaxPatches
/// surfaces at once, the reach is zero. The model is empty if the position is not finite, the
/// memory is of another view, or the view's tool has a body. Objects of `known` have one patch,
/// a mark, and do not end the reach. It never allocates.
LocalModel local_model(const ToolView& view, const Vec3& position, const TouchMemory& memory,
                       const KnownSurfaces& known = {}) noexcept;
/// As above, with the objects of the view at the places in `objects`. It is for a process that is
/// told the places of bodies and does not simulate them.
LocalModel local_model(const ToolView& view, const std::vector<Object>& objects,
                       const Vec3& position, const TouchMemory& memory) noexcept;
/// As above, with the moving objects at their present poses. Their patches have the velocity of the
/// surface. `held`: as in BodyContactState.
LocalModel local_model(const World& world, const Vec3& position, const TouchMemory& memory,
                       std::size_t held = 0, const KnownSurfaces& known = {}) noexcept;

}  // namespace feltwire
