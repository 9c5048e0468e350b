#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {
namespace {

/// A face counts as parallel to `away` if the cosine of the angle between its normal and `away`
/// differs from zero by at most this tolerance.
constexpr double kSide = 1e-6;

bool is_left_out(const SolidPart& part, std::size_t face, const Vec3& away) {
  return part.inner[face] == 0 && part.shape.planes[face].normal.dot(away) < -kSide;
}

}  // namespace

DepthPlanes::DepthPlanes(const SolidPart& part, const Vec3* away) noexcept {
  add_all(part, away);
  bool measured = false;
  for (std::size_t i = 0; i < count_; ++i) measured |= !planes_[i].inner;
  if (!measured) {  // Only inner faces are opposite the tool.
    count_ = 0;
    away = nullptr;
    add_all(part, away);
  }
  if (away != nullptr) add_outline(part, *away);
  double most = -2.0;
  for (std::size_t i = 0; away != nullptr && i < count_; ++i) {
    const double along = planes_[i].normal.dot(*away);
    if (!(along > most)) continue;
    most = along;
    facing_ = i;
  }
}

void DepthPlanes::add_all(const SolidPart& part, const Vec3* away) noexcept {
  for (std::size_t f = 0; f < part.shape.planes.size(); ++f)
    if (away == nullptr || !is_left_out(part, f, *away))
      add(part.shape.planes[f], part.inner[f] != 0);
  for (const HalfSpaceBelow& plane : part.beyond)
    if (away == nullptr || plane.normal.dot(*away) >= -kSide) add(plane, false);
}

void DepthPlanes::add_outline(const SolidPart& part, const Vec3& away) noexcept {
  const Polyhedron& shape = part.shape;
  for (const PolyhedronEdge& edge : shape.edges) {
    const bool left = is_left_out(part, edge.left, away);
    if (left == is_left_out(part, edge.right, away)) continue;
    const std::size_t kept = left ? edge.right : edge.left;
    // Skip a face parallel to `away`, because it is the plane of the outline itself. Skip an inner
    // face, because it bounds the part anyway.
    if (part.inner[kept] != 0 || shape.planes[kept].normal.dot(away) <= kSide) continue;
    const Vec3& on_edge = shape.vertices[edge.from];
    HalfSpaceBelow plane;
    plane.normal = (shape.vertices[edge.to] - on_edge).cross(away);
    const double length = plane.normal.norm();
    if (!(length > 0.0)) continue;
    plane.normal /= length;
    if (plane.normal.dot(shape.centre - on_edge) > 0.0) plane.normal = -plane.normal;
    plane.offset = plane.normal.dot(on_edge);
    add(plane, false);
  }
}

}  // namespace feltwire
