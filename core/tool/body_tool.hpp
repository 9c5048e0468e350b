#pragma once
// A body in the hand: a point shell or polygons that touch solids, coupled to the device by a
// spring.

#include <memory>
#include <optional>
#include <span>

#include "core/tool/polygon_body.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// A tool's body and its coupling, with all values filled in.
class BodyTool {
 public:
  /// `contact_area` [m^2]: A_c of add_contact(); 0 takes a sixth of the body's surface, which is
  /// the face of a cube. `inertia`: of a tool with mass. `polygons`: they touch, and the points
  /// only stand for the body where it is shown and in local models; null: the points touch. Throws
  /// std::invalid_argument that names the field and the remedy.
  BodyTool(PointShell shell, const ToolCoupling& coupling, double contact_area,
           const ToolInertia& inertia = {}, std::shared_ptr<const PolygonBody> polygons = nullptr);

  const PointShell& shell() const { return shell_; }
  const ToolCoupling& coupling() const { return coupling_; }  // nothing in it is zero
  double contact_area() const { return contact_area_; }
  const PolygonBody* polygons() const { return polygons_.get(); }  // null: points
  double radius() const;  // [m] of the farthest point or corner from the tool's origin
  const ToolInertia& inertia() const { return inertia_; }  // of mass 0: it has none

 private:
  PointShell shell_;
  ToolCoupling coupling_;
  double contact_area_;
  ToolInertia inertia_;
  std::shared_ptr<const PolygonBody> polygons_;
};

/// Moves the tool towards the balance of coupling and contact, or with its mass, as
/// step_coupled_tool(). Returns the force and torque of the coupling on the hand.
///
/// `elapsed`: [s] since the step before; at zero or less there is no damping. `motions`: one for
/// each object in that time; empty: all are static. `gravity` [m/s^2]: in place of the tool's own.
///
/// A tool of polygons must have a solid for each object, in their order.
///
/// A pose that is not finite gives zero and leaves the memory unchanged. Never allocates.
BodyStep step_body(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
                   double elapsed, BodyMemory& memory, std::span<const ObjectMotion> motions = {},
                   const std::optional<Vec3>& gravity = std::nullopt) noexcept;

}  // namespace feltwire
