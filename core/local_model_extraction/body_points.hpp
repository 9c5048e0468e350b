#pragma once

#include "core/dynamics/world.hpp"
#include "core/local_model/body_model.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// [m] The largest reach of a body's model: its points are those nearer to a surface.
inline constexpr double kBodyReach = 0.03;

/// [m] The largest reach of a model of solids.
inline constexpr double kSolidReach = 0.25;

/// What a tool with a body meets near the pose where its contacts hold it. `memory`: as touch() at
/// `device` left it. `known`: ToolBody::id of the body that the client knows; 0: it knows none.
///
/// A client that knows the tool's body gets the solids themselves, where all of those near have a
/// formula and are no more than kMaxBodySolids: its contact is the scene's (body_solids.hpp).
/// Else the shell is cut into at most kMaxBodyPoints parts, finest where it touches. At the model's
/// pose the force of each part is the scene's.
///
/// A solid or part that the model lacks is farther from the tool than its reach; only points beside
/// a solid's edge may be nearer, where all places are taken. The model is empty where the view's
/// tool has no body, or it was not placed yet. Never allocates.
BodyModel body_model(const ToolView& view, const Pose& device, const BodyMemory& memory,
                     std::uint32_t known = 0) noexcept;
/// The same, with the moving objects at their present poses. `held`: as in BodyContactState.
BodyModel body_model(const World& world, const Pose& device, const BodyMemory& memory,
                     std::uint32_t known = 0, std::size_t held = 0) noexcept;

}  // namespace feltwire
