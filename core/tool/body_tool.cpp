#include "core/tool/body_tool.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace feltwire {
namespace {

void require(bool good, const char* field, double value, const char* unit) {
  if (!good)
    throw std::invalid_argument(std::string(field) + ": must be above zero " + unit + ", is " +
                                std::to_string(value) + "; leave it out or give a larger number");
}

void check(const ToolInertia& tool) {
  const auto at_least_zero = [](double x) { return x >= 0.0 && std::isfinite(x); };
  require(tool.mass > 0.0 && std::isfinite(tool.mass), "mass", tool.mass, "[kg]");
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

/// The scene's objects, and how they moved in the step.
class Solids final : public ToolSurroundings {
 public:
  Solids(const BodyTool& tool, std::span<const Object> objects,
         std::span<const ObjectMotion> motions)
      : tool_(tool), objects_(objects), motions_(motions) {}

  ShellContact contact(const Pose& pose) const noexcept override {
    ShellContact sum;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      ObjectInStep in{.index = static_cast<std::uint32_t>(i)};
      if (i < motions_.size()) {
        const ObjectMotion& motion = motions_[i];
        const Vec3 arm = pose.position - objects_[i].pose.position;
        in.share = motion.share;
        in.carried << motion.linear + motion.angular.cross(arm), motion.angular;
      }
      add_contact(tool_.shell(), pose, objects_[i], tool_.contact_area(), sum, in);
    }
    return sum;
  }

 private:
  const BodyTool& tool_;
  std::span<const Object> objects_;
  std::span<const ObjectMotion> motions_;
};

}  // namespace

BodyTool::BodyTool(PointShell shell, const ToolCoupling& coupling, double contact_area,
                   const ToolInertia& inertia)
    : shell_(std::move(shell)),
      coupling_(coupling),
      contact_area_(contact_area),
      inertia_(inertia) {
  if (shell_.points.empty() || !(shell_.radius > 0.0))
    throw std::invalid_argument("body: has no extent about the tool's origin; give a larger one");
  ToolCoupling& c = coupling_;
  if (c.rotational_stiffness == 0.0)
    c.rotational_stiffness = c.stiffness * shell_.radius * shell_.radius;
  if (c.max_torque == 0.0) c.max_torque = c.max_force * shell_.radius;
  if (contact_area_ == 0.0) contact_area_ = shell_.area / 6.0;  // a cube's face
  const auto above_zero = [](double x) { return x > 0.0 && std::isfinite(x); };
  require(above_zero(c.stiffness), "stiffness", c.stiffness, "[N/m]");
  require(above_zero(c.rotational_stiffness), "rotational_stiffness", c.rotational_stiffness,
          "[N m/rad]");
  require(above_zero(c.max_force), "max_force", c.max_force, "[N]");
  require(above_zero(c.max_torque), "max_torque", c.max_torque, "[N m]");
  require(above_zero(contact_area_), "contact_area", contact_area_, "[m^2]");
  if (inertia_.mass != 0.0) check(inertia_);
}

BodyStep step_body(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
                   double elapsed, BodyMemory& memory, std::span<const ObjectMotion> motions,
                   const std::optional<Vec3>& gravity) noexcept {
  ToolInertia inertia = tool.inertia();
  if (gravity) inertia.gravity = *gravity;
  return step_coupled_tool({tool.coupling(), tool.shell().radius, !motions.empty(), &inertia},
                           Solids(tool, objects, motions), device, elapsed, memory);
}

}  // namespace feltwire
