#pragma once

#include "core/dynamics/world.hpp"
#include "core/local_model/body_model.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// [m] The largest reach of a body's model: it contains the points nearer to a surface. Where the
/// receiver has all objects in full, it is kModelReach.
inline constexpr double kBodyReach = 0.03;
/// A model with fewer points than this would be empty.
inline constexpr int kLeastBodyPoints = 4;

/// The contacts of a tool with a body near the pose at which they hold it. `memory`: the result of
/// touch() at `device`.
///
/// The shell is cut into at most kMaxBodyPoints parts, finest where it touches. At the model's pose
/// the force of each part is the scene's.
///
/// All other parts are farther from every surface than the model's reach. If all places are taken,
/// points beside a solid's edge may be nearer. The model is empty if the view's tool has no body or
/// was not placed yet. It never allocates.
///
/// `version`: of the tool and solids that the receiver has in full (PrefetchedTool), 0: none. Then
/// the objects of `known` have no points and do not end the reach. Without them the model of a tool
/// with mass is empty: a receiver would render it without mass.
///
/// `most`: of its points; with fewer it is coarser, or its reach is less.
BodyModel body_model(const ToolView& view, const Pose& device, const BodyMemory& memory,
                     std::uint32_t version = 0, const KnownSurfaces& known = {},
                     int most = kMaxBodyPoints) noexcept;
/// As above, with the moving objects at their present poses. `held`: as in BodyContactState.
BodyModel body_model(const World& world, const Pose& device, const BodyMemory& memory,
                     std::size_t held = 0, std::uint32_t version = 0,
                     const KnownSurfaces& known = {}, int most = kMaxBodyPoints) noexcept;

}  // namespace feltwire
