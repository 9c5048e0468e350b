#pragma once

#include "core/dynamics/world.hpp"
#include "core/local_model/body_model.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

/// Puts the solids near the tool into a model that has its pose, and its reach as far as solids may
/// be looked for. Shortens the reach to the nearest object that is left out. Returns false, and
/// leaves the model as it was, where they cannot say all that is near: one of them has no formula,
/// there are too many, or one is too large or too far for the numbers of a datagram. `world`: that
/// moves them, or null. Never allocates.
bool add_solids(const BodyTool& tool, const std::vector<Object>& objects, const World* world,
                BodyModel& model) noexcept;

}  // namespace feltwire
