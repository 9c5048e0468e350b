#pragma once
// A tool point against an object: penalty force from the proxy, friction from a stick point.

#include <cmath>
#include <string>

#include "core/base/types.hpp"
#include "core/contact/ball.hpp"
#include "core/contact/surface_point.hpp"
#include "core/material/contact_law.hpp"
#include "core/material/material.hpp"

namespace feltwire {

struct Object {
  std::string name;
  Shape shape;
  Side felt_from = Side::outside;
  Pose pose;
  Material material;
  std::string material_name = {};  // in the scene file; empty: not known
};

/// The object's force on the hand [N, world], by contact_law.hpp. A free tool gets zero and a
/// cleared memory. The tool is a point, or a ball where `radius` [m] is above zero.
Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius = 0.0) noexcept;

/// The proxy in the object's frame, for a tool at `tool` [m, world].
inline SurfacePoint surface_point(const Object& object, const Vec3& tool, double radius,
                                  FeatureMemory& memory, WorkLimit* work = nullptr) noexcept {
  const Vec3 position = object.pose.orientation.conjugate() * (tool - object.pose.position);
  return radius > 0.0 ? ball_surface(object.shape, object.felt_from, position, radius, memory, work)
                      : surface_point(object.shape, object.felt_from, position, memory, work);
}

/// Like touch(), with the two forces apart. Returns false for a free tool, and then writes neither
/// force.
bool touch(const Object& object, const Tool& tool, ContactMemory& memory, double radius,
           Vec3& elastic, Vec3& frictional) noexcept;
/// As above, but the object has this material instead of its own. Where `work` is cut off, the tool
/// counts as free and the memory stays as it was.
bool touch(const Object& object, const Material& material, const Tool& tool, ContactMemory& memory,
           double radius, Vec3& elastic, Vec3& frictional, WorkLimit* work = nullptr) noexcept;

/// Adds touch() to `sum`. It is called for every object of a scene with every sample. Most objects
/// are plain springs that are not touched; these cost only a test of their surface.
inline void add_touch(const Object& object, const Tool& tool, ContactMemory& memory, double radius,
                      Command& sum) noexcept {
  if (!object.material.is_spring()) {
    Vec3 elastic, frictional;
    if (!touch(object, tool, memory, radius, elastic, frictional)) return;
    sum.elastic += elastic;
    sum.frictional += frictional;
    return;
  }
  const SurfacePoint surface = surface_point(object, tool.position, radius, memory.feature);
  memory.touching = surface.depth > 0.0;
  if (!memory.touching) return;
  const Vec3 elastic =
      object.material.stiffness * surface.depth * (object.pose.orientation * surface.normal);
  if (std::isfinite(elastic.sum())) [[likely]]
    sum.elastic += elastic;
  else
    memory = {};  // the sizes or positions overflow a product
}

}  // namespace feltwire
