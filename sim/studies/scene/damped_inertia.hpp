#pragma once

#include <cmath>

#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// The inertia with dampers beside the coupling that damp it critically: the translation, and the
/// mean of the three axes of rotation.
inline ToolInertia critically_damped(ToolInertia inertia, const ToolCoupling& coupling) {
  inertia.damping = 2.0 * std::sqrt(coupling.stiffness * inertia.mass);
  inertia.rotational_damping =
      2.0 * std::sqrt(coupling.rotational_stiffness * inertia.inertia.trace() / 3.0);
  return inertia;
}

}  // namespace feltwire
