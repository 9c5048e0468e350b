#pragma once
// Internal to core/scene: what a compiled model gives reason to warn of.

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {

/// `object_of` says for each geom which object it is, -1: none.
std::vector<std::string> warnings_of(const mjModel& model, const std::vector<Object>& objects,
                                     const std::vector<int>& object_of, std::size_t still,
                                     const std::vector<Mechanism::Part>& parts);

}  // namespace feltwire::mujoco
