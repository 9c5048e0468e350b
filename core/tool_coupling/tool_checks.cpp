#include "core/tool_coupling/tool_checks.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>

namespace feltwire {

void require_above_zero(const char* field, double value, const char* unit) {
  if (!(value > 0.0 && std::isfinite(value)))
    throw std::invalid_argument(std::string(field) + ": must be above zero " + unit + ", is " +
                                std::to_string(value) + "; leave it out or give a larger number");
}

void check(const ToolCoupling& c) {
  require_above_zero("stiffness", c.stiffness, "[N/m]");
  require_above_zero("rotational_stiffness", c.rotational_stiffness, "[N m/rad]");
  require_above_zero("max_force", c.max_force, "[N]");
  require_above_zero("max_torque", c.max_torque, "[N m]");
}

void check(const ToolInertia& tool) {
  if (tool.mass == 0.0) return;
  const auto at_least_zero = [](double x) { return x >= 0.0 && std::isfinite(x); };
  require_above_zero("mass", tool.mass, "[kg]");
  if (!at_least_zero(tool.damping) || !at_least_zero(tool.rotational_damping))
    throw std::invalid_argument(
        "coupling.damping: must be zero or above; leave it out or give a larger number");
  if (!tool.center.allFinite() || !tool.gravity.allFinite())
    throw std::invalid_argument("mass: its centre or gravity is not finite; give finite numbers");
  const bool symmetric = tool.inertia.isApprox(tool.inertia.transpose(), 1e-9);
  if (!tool.inertia.allFinite() || !symmetric ||
      Eigen::LLT<Mat3>(tool.inertia).info() != Eigen::Success)
    throw std::invalid_argument(
        "mass: its moments of inertia are not those of a body; give it an extent in every "
        "direction");
}

}  // namespace feltwire
