#include "core/contact/contact.hpp"

#include <algorithm>

#include "core/numeric.hpp"

namespace feltwire {
namespace {

/// How far the stick spring is stretched along the surface [m, object frame]; moves the anchor and
/// the stick / slip state on by one sample.
///
/// Spring and surface have the same stiffness, so the cone |F_t| <= mu F_n is a cone of lengths:
/// |stretch| <= mu * depth, in which the stiffness has no part.
Vec3 stick_stretch(const Material& material, const SurfacePoint& surface, ContactMemory& memory) {
  if (!memory.touching) {
    memory.anchor = surface.point;
    memory.slipping = false;
    return Vec3::Zero();
  }
  // What an anchor on a curved surface pulls with is its part in the tangent plane of where the
  // proxy now is; the rest is the surface's business.
  const Vec3 chord = memory.anchor - surface.point;
  Vec3 stretch = chord - along(chord, surface.normal);
  const double stretched = length(stretch);

  const double mu = memory.slipping ? material.dynamic_friction : material.static_friction;
  memory.slipping = stretched > mu * surface.depth;
  if (memory.slipping) {
    // At the break the force falls from mu_s F_n to mu_d F_n; the anchor is dragged along.
    stretch *= material.dynamic_friction * surface.depth / stretched;
    memory.anchor = surface.point + stretch;
  }
  return stretch;
}

}  // namespace

Command touch(const Object& object, const Tool& tool, ContactMemory& memory) noexcept {
  const Material& material = object.material;
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 position = to_world.conjugate() * (tool.position - object.pose.position);
  const SurfacePoint surface =
      surface_point(object.shape, object.felt_from, position, memory.feature);
  if (!(surface.depth > 0.0)) {
    memory = {};
    return {};
  }

  const Vec3 normal = to_world * surface.normal;
  const double elastic = material.stiffness * surface.depth;

  Command command;
  command.elastic = elastic * normal;
  if (material.static_friction > 0.0)
    command.frictional = to_world * (material.stiffness * stick_stretch(material, surface, memory));
  if (material.viscous_friction > 0.0 || material.damping > 0.0) {
    const double leaving = tool.velocity.dot(normal);  // [m/s] out of the surface
    command.frictional -= material.viscous_friction * (tool.velocity - leaving * normal);
    command.frictional += std::max(-elastic, -material.damping * leaving) * normal;
  }
  memory.touching = true;
  if (!command.finite()) [[unlikely]] {  // sizes or positions beyond what products can hold
    memory = {};
    return {};
  }
  return command;
}

}  // namespace feltwire
