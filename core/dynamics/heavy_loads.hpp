#pragma once
// Bodies that stand on a body so light that they sink into it.

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "core/contact/contact.hpp"

namespace feltwire::mujoco {

/// A contact of MuJoCo is soft: it yields by the share 1 - d of the load, whose stiffness is that
/// of the lighter body's mass. So a heavy body sinks into a light one that it stands on, and passes
/// it (yield_under_load()). Finds the pairs whose yield is a notable share of the light body, and
/// says the yield, the thickness and the remedy. `data`: the model's start, evaluated. `object_of`:
/// the object of each geom; -1: none.
std::vector<std::string> heavy_loads(const mjModel& model, const mjData& data,
                                     const std::vector<Object>& objects,
                                     const std::vector<int>& object_of);

/// [m] The way by which a light body's contact yields under a load of `ratio` times its own mass,
/// if one point bears it. `gravity` [m/s^2]; `contact` [s] is the time constant of the contact
/// (solref), `impedance` its least impedance d (solimp).
double yield_under_load(double ratio, double gravity, double contact, double impedance);

}  // namespace feltwire::mujoco
