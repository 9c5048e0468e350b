#pragma once

#include "core/dynamics/world.hpp"
#include "core/local_model/local_model.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// [m] No model reaches farther: a hand at 1 m/s needs a tenth of a second for it, by when a
/// command of the usual hold time is gone.
inline constexpr double kModelReach = 0.1;

/// The surfaces of the scene near a tool position [m, world], nearest first: those that the tool
/// stands on before all, then those that would be met first. `memory` as touch() at that position
/// left it. What is left out begins beyond the reach; in a place with more than kMaxPatches
/// surfaces at once the reach is zero. A position that is not finite, or a memory of another view,
/// gives a model that says nothing; so does a view whose tool is not a point. Never allocates.
LocalModel local_model(const ToolView& view, const Vec3& position,
                       const TouchMemory& memory) noexcept;
/// The same with the moving objects where they are; their patches have the velocity of the surface.
/// `held`: which of the scene's tools (BodyContactState::held).
LocalModel local_model(const World& world, const Vec3& position, const TouchMemory& memory,
                       std::size_t held = 0) noexcept;

}  // namespace feltwire
