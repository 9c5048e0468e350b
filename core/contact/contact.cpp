#include "core/contact/contact.hpp"

#include <cmath>

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

bool add_touch(const Object& object, const Tool& tool, ContactMemory& memory, double radius,
               Command& sum) noexcept {
  const Material& material = object.material;
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 position = to_world.conjugate() * (tool.position - object.pose.position);
  const auto* mesh = material.static_friction > 0.0 && memory.touching
                         ? std::get_if<Mesh>(&object.shape)
                         : nullptr;
  Vec3 proxy_before = Vec3::Zero(), normal_before = Vec3::Zero();
  if (mesh != nullptr) {
    proxy_before = memory.feature.proxy;
    normal_before = memory.feature.normal;
  }
  const SurfacePoint surface =
      radius > 0.0 ? ball_surface(object.shape, object.felt_from, position, radius, memory.feature)
                   : surface_point(object.shape, object.felt_from, position, memory.feature);
  if (!(surface.depth > 0.0)) {
    memory.touching = memory.slipping = false;
    return false;
  }

  Vec3 stick_force = Vec3::Zero();
  if (material.static_friction > 0.0) {
    if (mesh != nullptr)
      memory.anchor = carried(memory.anchor, mesh->surface->mesh().origin() + proxy_before,
                              normal_before, surface.normal);
    stick_force = to_world * (material.stiffness * stick_stretch(material, surface, memory));
  }
  const Command command =
      contact_force(material, surface.depth, to_world * surface.normal, stick_force, tool.velocity);
  memory.touching = true;
  if (!std::isfinite(command.force().sum())) [[unlikely]] {
    memory = {};  // sizes or positions beyond what products can hold
    return false;
  }
  sum.elastic += command.elastic;
  sum.frictional += command.frictional;
  return true;
}

Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius) noexcept {
  Command command;
  add_touch(object, tool, memory, radius, command);
  return command;
}

}  // namespace feltwire
