#include "core/contact/contact.hpp"

#include "core/contact/ball.hpp"
#include "core/geometry/mesh_surface.hpp"

namespace feltwire {
namespace {

/// From facet to facet the stick spring turns with the surface, so that it is as long after an edge
/// as before: without that a hand would get round corners by each facet's cosine for nothing.
Vec3 carried(const Vec3& anchor, const Vec3& about, const Vec3& from, const Vec3& to) {
  const double cosine = from.dot(to);
  const Vec3 axis = from.cross(to), v = anchor - about;
  if (!(cosine > -0.5)) return anchor;  // turned right round: another place
  return about + cosine * v + axis.cross(v) + axis.dot(v) / (1.0 + cosine) * axis;
}

}  // namespace

Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius) noexcept {
  const Material& material = object.material;
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 position = to_world.conjugate() * (tool.position - object.pose.position);
  const FeatureMemory before = memory.feature;
  const SurfacePoint surface =
      radius > 0.0 ? ball_surface(object.shape, object.felt_from, position, radius, memory.feature)
                   : surface_point(object.shape, object.felt_from, position, memory.feature);
  if (!(surface.depth > 0.0)) {
    memory.touching = memory.slipping = false;
    return {};
  }

  Vec3 stick_force = Vec3::Zero();
  if (material.static_friction > 0.0) {
    if (const auto* mesh = std::get_if<Mesh>(&object.shape); mesh && memory.touching)
      memory.anchor = carried(memory.anchor, mesh->surface->mesh().origin() + before.proxy,
                              before.normal, surface.normal);
    stick_force = to_world * (material.stiffness * stick_stretch(material, surface, memory));
  }
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
