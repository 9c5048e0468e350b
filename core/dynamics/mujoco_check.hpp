#pragma once
// Internal to core/dynamics: warnings about a compiled model.

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {

/// `start`: its coordinates (qpos); empty: those of the model. `object_of`: for each geom its
/// object, or -1. `still`: the number of static objects.
std::vector<std::string> warnings_of(const mjModel& model, const std::vector<mjtNum>& start,
                                     const std::vector<Object>& objects,
                                     const std::vector<int>& object_of, std::size_t still,
                                     const std::vector<Mechanism::Part>& parts);

}  // namespace feltwire::mujoco
