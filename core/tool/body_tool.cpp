#include "core/tool/body_tool.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/coupled_tool/descent.hpp"

namespace feltwire {
namespace {

void require(bool good, const char* field, double value, const char* unit) {
  if (!good)
    throw std::invalid_argument(std::string(field) + ": must be above zero " + unit + ", is " +
                                std::to_string(value) + "; leave it out or give a larger number");
}

/// The scene's objects for a tool of polygons, near these pairs.
class PolygonSolids final : public ToolSurroundings {
 public:
  PolygonSolids(const BodyTool& tool, std::span<const Object> objects,
                std::span<const ObjectMotion> motions, PartPairs& near)
      : tool_(tool), objects_(objects), motions_(motions), near_(near) {}

  ShellContact contact(const Pose& pose) const noexcept override {
    return polygon_contact(*tool_.polygons(), objects_, tool_.contact_area(), near_, pose, motions_,
                           &near_.push);
  }

 private:
  const BodyTool& tool_;
  std::span<const Object> objects_;
  std::span<const ObjectMotion> motions_;
  PartPairs& near_;
};

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
    for (std::size_t i = 0; i < objects_.size(); ++i)
      add_contact(tool_.shell(), pose, objects_[i], tool_.contact_area(), sum,
                  in_step(i, objects_[i], motions_, pose));
    return sum;
  }

 private:
  const BodyTool& tool_;
  std::span<const Object> objects_;
  std::span<const ObjectMotion> motions_;
};

}  // namespace

BodyTool::BodyTool(PointShell shell, const ToolCoupling& coupling, double contact_area,
                   const ToolInertia& inertia, std::shared_ptr<const PolygonBody> polygons)
    : shell_(std::move(shell)),
      coupling_(coupling),
      contact_area_(contact_area),
      inertia_(inertia),
      polygons_(std::move(polygons)) {
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

double BodyTool::radius() const {
  return polygons_ ? std::max(shell_.radius, polygons_->radius) : shell_.radius;
}

BodyStep step_body(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
                   double elapsed, BodyMemory& memory, std::span<const ObjectMotion> motions,
                   const std::optional<Vec3>& gravity) noexcept {
  ToolInertia inertia = tool.inertia();
  if (gravity) inertia.gravity = *gravity;
  const CoupledTool coupled{tool.coupling(), tool.radius(), !motions.empty(), &inertia};
  if (const PolygonBody* polygons = tool.polygons()) {
    if (objects.size() != polygons->solids.size()) [[unlikely]]
      return {};
    if (!coupled_tool::good(device)) return {};
    Pose start = memory.placed ? memory.pose : device;
    start.orientation.normalize();
    look_round(*polygons, objects, start, !memory.known || !motions.empty(), memory.near);
    // The contact at the pose is known; how far it is clear was that of the step before.
    if (memory.known) memory.contact.clearance = clearance(memory.near);
    return step_coupled_tool(coupled, PolygonSolids(tool, objects, motions, memory.near), device,
                             elapsed, memory);
  }
  return step_coupled_tool(coupled, Solids(tool, objects, motions), device, elapsed, memory);
}

}  // namespace feltwire
