#include "core/contact/contact.hpp"

#include "core/contact/ball.hpp"

namespace feltwire {

Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius) noexcept {
  const Material& material = object.material;
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 position = to_world.conjugate() * (tool.position - object.pose.position);
  const SurfacePoint surface =
      radius > 0.0 ? ball_surface(object.shape, object.felt_from, position, radius, memory.feature)
                   : surface_point(object.shape, object.felt_from, position, memory.feature);
  if (!(surface.depth > 0.0)) {
    memory = {};
    return {};
  }

  Vec3 stick_force = Vec3::Zero();
  if (material.static_friction > 0.0)
    stick_force = to_world * (material.stiffness * stick_stretch(material, surface, memory));
  Command command =
      contact_force(material, surface.depth, to_world * surface.normal, stick_force, tool.velocity);
  memory.touching = true;
  if (!command.finite()) [[unlikely]] {  // sizes or positions beyond what products can hold
    memory = {};
    return {};
  }
  return command;
}

}  // namespace feltwire
