#include "core/geometry/box.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/solid_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {
namespace {

double face_sign(int face) { return face % 2 == 0 ? 1.0 : -1.0; }

/// Returns the index of the face through which the path enters the box, or -1 if the path does not
/// enter. The path begins outside the box.
int box_entry(const Vec3& h, const Vec3& from, const Vec3& to) {
  double in = 0.0, out = 1.0;
  int entered = -1;
  for (int face = 0; face < kBoxFaces; ++face) {
    const int axis = face / 2;
    const double sign = face_sign(face);
    const double before = sign * from[axis] - h[axis], after = sign * to[axis] - h[axis];
    if (before >= 0.0 && after >= 0.0) return -1;
    if (before >= 0.0) {
      const double part = before / (before - after);
      if (entered >= 0 && !(part > in)) continue;
      in = part;
      entered = face;
    } else if (after >= 0.0) {
      out = std::min(out, before / (before - after));
    }
  }
  return in < out ? entered : -1;
}

SurfacePoint box_from_outside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  // The solid is convex, so a tool that is still inside has crossed no other face since its entry.
  // If the face of entry is unknown, use the nearest face.
  int face = static_cast<int>(memory.feature) - 1;
  if (face < 0 || face >= kBoxFaces) {
    face = memory.tracked ? box_entry(h, memory.proxy, p) : -1;
    if (face < 0) {
      const Vec3 deep = h - p.cwiseAbs();
      if (!(deep.x() > 0.0 && deep.y() > 0.0 && deep.z() > 0.0)) return free_at(p, memory);
      Eigen::Index axis;
      deep.minCoeff(&axis);
      face = 2 * static_cast<int>(axis) + (p[axis] < 0.0 ? 1 : 0);
    }
  }
  const int axis = face / 2;
  const double sign = face_sign(face);
  const double depth = h[axis] - sign * p[axis];
  for (int other = 0; other < 3; ++other)
    if (other != axis && !(std::abs(p[other]) < h[other])) return free_at(p, memory);
  if (!(depth > 0.0)) return free_at(p, memory);
  Vec3 point = p;
  point[axis] = sign * h[axis];
  return held_on({point, sign * Vec3::Unit(axis), depth}, face, memory);
}

/// Computes the contact with a hollow box. The free space inside is convex, so the proxy is the
/// tool position clamped to the box: on a face, an edge or a corner. The force acts along the line
/// from the tool to the proxy.
SurfacePoint box_from_inside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  const Vec3 point = p.cwiseMax(-h).cwiseMin(h);
  const Vec3 beyond = p - point;
  const double depth = length(beyond);
  if (!(depth > 0.0)) return no_contact(memory);
  Eigen::Index axis;
  beyond.cwiseAbs().maxCoeff(&axis);
  const int face = 2 * static_cast<int>(axis) + (beyond[axis] < 0.0 ? 1 : 0);
  return stand_on(point, -direction(beyond), depth, face, memory);
}

}  // namespace

SurfacePoint Box::surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept {
  return side == Side::outside ? box_from_outside(half_extents, p, memory)
                               : box_from_inside(half_extents, p, memory);
}

Grown<Box> Box::grown(Side side, double ball) const noexcept {
  if (side == Side::outside) return {*this, Vec3::Zero(), ball};
  return {{half_extents - Vec3::Constant(ball)}};
}

double Box::room() const noexcept { return half_extents.minCoeff(); }

FieldPoint Box::signed_distance(const Vec3& p) const noexcept {
  const Vec3 beyond = p.cwiseAbs() - half_extents;
  const auto sign = [&](Eigen::Index axis) { return p[axis] < 0.0 ? -1.0 : 1.0; };
  Eigen::Index axis;
  const double most = beyond.maxCoeff(&axis);
  if (!(most > 0.0)) return {most, sign(axis) * Vec3::Unit(axis)};
  Vec3 out = beyond.cwiseMax(0.0);
  for (Eigen::Index i = 0; i < 3; ++i) out[i] *= sign(i);
  const Polar<double> way = polar(out);
  return {way.length, way.direction};
}

Vec3 Box::half_box() const noexcept { return half_extents; }

double Box::reach() const noexcept { return half_extents.norm(); }

MassProperties Box::mass_properties() const {
  const double volume = 8.0 * half_extents.prod();
  const Vec3 square = half_extents.cwiseAbs2();
  return {volume, Vec3::Zero(),
          volume / 3.0 * Vec3(Vec3::Constant(square.sum()) - square).asDiagonal().toDenseMatrix()};
}

TriangleSoup Box::triangles(int) const {
  const Vec3& h = half_extents;
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i)
    soup.vertices.emplace_back((i & 1) != 0 ? h.x() : -h.x(), (i & 2) != 0 ? h.y() : -h.y(),
                               (i & 4) != 0 ? h.z() : -h.z());
  soup.triangles = {{1, 3, 7}, {1, 7, 5}, {0, 4, 6}, {0, 6, 2}, {2, 6, 7}, {2, 7, 3},
                    {0, 1, 5}, {0, 5, 4}, {4, 5, 7}, {4, 7, 6}, {0, 2, 3}, {0, 3, 1}};
  return soup;
}

/// Returns the collision geoms. Six planes replace a hollow box.
std::vector<PhysicsGeom> Box::geoms(Side side) const {
  if (side == Side::outside) return {{.kind = PhysicsGeom::Kind::box, .size = half_extents}};
  std::vector<PhysicsGeom> walls;
  for (int face = 0; face < kBoxFaces; ++face) {
    const Vec3 outward = face_sign(face) * Vec3::Unit(face / 2);
    walls.push_back(
        {.kind = PhysicsGeom::Kind::plane,
         .pose = Pose{outward.cwiseProduct(half_extents), turn_to(Vec3::UnitZ(), -outward)}});
  }
  return walls;
}

SurfaceParts Box::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const Vec3& h = half_extents;
  const Vec3 out = (p.cwiseAbs() - h).cwiseMax(0.0);
  const double solid = out.norm();
  for (int face = 0; face < kBoxFaces; ++face) {
    const int axis = face / 2;
    const double inward = std::max(0.0, h[axis] - face_sign(face) * p[axis]);
    if (side == Side::inside) {
      add(all, inward, feature_of(face));
      continue;
    }
    Vec3 way = out;  // vector from p to a point that is beyond only this face
    way[axis] = inward;
    add_convex(all, way.norm(), solid, face, entered);
  }
  return all;
}

PatchGeometry Box::patch(Side side, const Vec3& p, int face, const FeatureMemory&,
                         bool) const noexcept {
  const Vec3& h = half_extents;
  PatchGeometry s{.point = p.cwiseMax(-h).cwiseMin(h),
                  .normal = outward_sign(side) * face_sign(face) * Vec3::Unit(face / 2),
                  .joined = side == Side::outside};
  s.point[face / 2] = face_sign(face) * h[face / 2];
  return s;
}

}  // namespace feltwire
