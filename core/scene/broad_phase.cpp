#include "core/scene/broad_phase.hpp"

#include <limits>
#include <optional>

#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

/// A box in the object's frame, about its middle.
struct OwnBox {
  Vec3 middle = Vec3::Zero(), half = Vec3::Zero();  // [m]
};

std::optional<OwnBox> own_box(const Object& object) {
  // For an object felt from inside, everything beyond the walls is solid.
  if (object.felt_from == Side::inside) return std::nullopt;
  if (const auto* mesh = std::get_if<Mesh>(&object.shape)) {
    const TriangleMesh& triangles = mesh->surface->mesh();
    return OwnBox{triangles.origin(),
                  triangles.half_extents() + Vec3::Constant(mesh->surface->options().radius)};
  }
  return on_primitive(
      object.shape,
      [](const auto& solid) -> std::optional<OwnBox> {
        if (!is_bounded(solid)) return std::nullopt;
        return OwnBox{Vec3::Zero(), solid.half_box()};
      },
      [] { return std::optional<OwnBox>(); });
}

Bounds world_box(const Object& object, const OwnBox& own) {
  constexpr double kRounding = 1e-12;  // generous share of the coordinates
  const Mat3 to_world = object.pose.orientation.toRotationMatrix();
  const Vec3 middle = object.pose.position + to_world * own.middle;
  const Vec3 half = to_world.cwiseAbs() * own.half;
  const double more = kRounding * (object.pose.position.norm() + own.middle.norm() + half.norm());
  return Bounds{middle - half, middle + half}.grown(more);
}

}  // namespace

ReachBall reach_ball(const Object& object) {
  constexpr double kRounding = 1e-12;  // generous share of the size
  const auto own = own_box(object);
  if (!own) return {Vec3::Zero(), std::numeric_limits<double>::infinity()};
  const double radius = on_primitive(
      object.shape, [](const auto& solid) { return solid.reach(); },
      [&] { return own->half.norm(); });
  return {own->middle, radius + kRounding * (own->middle.norm() + radius)};
}

BroadPhase::BroadPhase(std::span<const Object> objects, double radius) {
  if (objects.size() < kFew) return;
  std::vector<Bounds> boxes;
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    const auto own = own_box(objects[i]);
    if (!own) {
      everywhere_.push_back(i);
      continue;
    }
    bounded_.push_back(i);
    boxes.push_back(world_box(objects[i], *own).grown(radius));
  }
  tree_ = BoxTree(boxes);
}

}  // namespace feltwire
