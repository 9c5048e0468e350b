#include "client/servo/rise_limit.hpp"

#include <algorithm>

#include "core/bounding/frame.hpp"

namespace feltwire {

double rise(const LocalModel& model, double way, double elapsed) noexcept {
  double allowed = 0.0;
  for (const SurfacePatch& patch : model.view()) {
    const Material& m = patch.material;
    const double over = way + length(patch.velocity) * elapsed;
    // Add the spring along the normal and the friction spring, each with its damper.
    allowed += 2.0 * m.stiffness * over;
    if (elapsed > 0.0) allowed += (m.damping + m.viscous_friction) * over / elapsed;
  }
  return allowed;
}

Command RiseLimit::apply(const Command& command, const LocalModel& model, double way,
                         double elapsed, double beside) noexcept {
  const double allowed = last_ + slew_ * elapsed + rise(model, way, elapsed) + beside;
  const double wanted = length(command.force());
  last_ = std::min(wanted, allowed);
  return reduction(allowed, wanted) * command;
}

Command RiseLimit::apply(const Command& command, const BodyModel& model, double way, double turn,
                         double elapsed, const ToolInertia* inertia) noexcept {
  const ToolCoupling& c = model.coupling;
  double fastest = 0.0;  // [m/s] speed of the fastest surface
  for (const BodyPatch& patch : model.surfaces())
    fastest = std::max(fastest, length(patch.velocity));
  way += fastest * elapsed;  // a moving surface moves the tool
  // The factor 2 allows for a tool that moves towards the device. A translation can also press a
  // contact point at the tool's radius, and a rotation moves this point.
  double force = last_ + slew_ * elapsed + 2.0 * c.stiffness * (way + model.radius * turn);
  double torque = last_torque_ + torque_slew_ * elapsed +
                  2.0 * (c.rotational_stiffness * turn + c.stiffness * model.radius * way);
  if (inertia != nullptr && elapsed > 0.0) {  // add the damper in parallel to the spring
    force += inertia->damping * way / elapsed;
    torque += inertia->rotational_damping * turn / elapsed;
  }
  const double wanted = length(command.force()), wanted_torque = length(command.torque);
  const double scale = std::min(reduction(force, wanted), reduction(torque, wanted_torque));
  last_ = scale * wanted;
  last_torque_ = scale * wanted_torque;
  return scale * command;
}

}  // namespace feltwire
