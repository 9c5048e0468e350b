#include "core/tool/body_tool.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/point_shell/shell_surroundings.hpp"
#include "core/tool_coupling/descent.hpp"
#include "core/tool_coupling/tool_checks.hpp"

namespace feltwire {
namespace {

/// The scene's objects around a tool of polygons. Only the part pairs in `near` are evaluated.
class PolygonSolids final : public ToolSurroundings {
 public:
  PolygonSolids(const BodyTool& tool, std::span<const Object> objects,
                std::span<const ObjectMotion> motions, PartPairs& near)
      : tool_(tool), objects_(objects), motions_(motions), near_(near) {}

  /// Computes the contact. Only a server calls this function, so the work has no limit.
  ShellContact contact(const Pose& pose, WorkLimit*) const noexcept override {
    return polygon_contact(*tool_.polygons(), objects_, tool_.contact_area(), near_, pose, motions_,
                           &near_.push);
  }

 private:
  const BodyTool& tool_;
  std::span<const Object> objects_;
  std::span<const ObjectMotion> motions_;
  PartPairs& near_;
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
  if (contact_area_ == 0.0) contact_area_ = shell_.area / 6.0;  // area of a cube's face
  check(c);
  require_above_zero("contact_area", contact_area_, "[m^2]");
  check(inertia_);
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
    if (!tool_coupling::good(device)) return {};
    Pose start = memory.placed ? memory.pose : device;
    start.orientation.normalize();
    update_part_pairs(*polygons, objects, start, !memory.known || !motions.empty(), memory.near);
    // The contact at this pose is known, but the stored clearance is from the previous step.
    if (memory.known) memory.contact.clearance = clearance(memory.near);
    return step_coupled_tool(coupled, PolygonSolids(tool, objects, motions, memory.near), device,
                             elapsed, memory);
  }
  return step_coupled_tool(coupled,
                           ShellSurroundings(tool.shell(), tool.contact_area(), objects, motions),
                           device, elapsed, memory);
}

}  // namespace feltwire
