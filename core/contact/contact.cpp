#include "core/contact/contact.hpp"

#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

bool touch(const Object& object, const Tool& tool, ContactMemory& memory, double radius,
           Vec3& elastic, Vec3& frictional) noexcept {
  return touch(object, object.material, tool, memory, radius, elastic, frictional);
}

bool touch(const Object& object, const Material& material, const Tool& tool, ContactMemory& memory,
           double radius, Vec3& elastic, Vec3& frictional, WorkLimit* work) noexcept {
  const Quaternion& to_world = object.pose.orientation;
  const bool rubs = material.static_friction > 0.0;
  const auto* mesh = rubs && memory.touching ? std::get_if<Mesh>(&object.shape) : nullptr;
  Vec3 proxy_before = Vec3::Zero(), normal_before = Vec3::Zero();
  if (mesh != nullptr) {
    proxy_before = memory.feature.proxy;
    normal_before = memory.feature.normal;
  }
  const SurfacePoint surface = surface_point(object, tool.position, radius, memory.feature, work);
  if (is_cut(work)) [[unlikely]]
    return false;
  if (!(surface.depth > 0.0)) {
    memory.touching = memory.slipping = false;
    return false;
  }
  if (mesh != nullptr)
    memory.anchor = carried(memory.anchor, mesh->surface->mesh().origin() + proxy_before,
                            normal_before, surface.normal);
  Vec3 stick_force = Vec3::Zero();
  if (rubs)
    stick_force = to_world * (material.stiffness * stick_stretch(material, surface, memory));
  memory.touching = true;
  const Command command =
      contact_force(material, surface.depth, to_world * surface.normal, stick_force, tool.velocity);
  if (!std::isfinite(command.force().sum())) [[unlikely]] {
    memory = {};  // A product of sizes or positions has overflowed.
    return false;
  }
  elastic = command.elastic;
  frictional = command.frictional;
  return true;
}

Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius) noexcept {
  Command command;
  touch(object, tool, memory, radius, command.elastic, command.frictional);
  return command;
}

}  // namespace feltwire
