#include "core/local_model_extraction/patches.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/round_proxy.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kOnlyFeature = 1;

// What underflows here is a distance that is taken for nothing, which is on the safe side; a scene
// has no lengths that would overflow.
double root(double a, double b) { return std::sqrt(a * a + b * b); }

std::uint32_t feature_of(int face) { return static_cast<std::uint32_t>(1 + face); }
int face_of(std::uint32_t feature) { return static_cast<int>(feature) - 1; }
double face_sign(int face) { return face % 2 == 0 ? 1.0 : -1.0; }

void add(SurfaceParts& all, double distance, std::uint32_t feature, bool shown = true) {
  all.parts[static_cast<std::size_t>(all.count++)] = {distance, feature, shown};
}

/// One of several faces that bound a convex solid together: it begins to count where the solid
/// does, and where the tool could be beyond it and inside the others. The face that the tool stands
/// on counts wherever it is.
void add_convex(SurfaceParts& all, double beyond, double solid, int face, std::uint32_t entered) {
  const std::uint32_t feature = feature_of(face);
  add(all, feature == entered ? 0.0 : std::max(beyond, solid), feature);
}

SurfaceParts parts(const Plane&, Side side, const Vec3& p, std::uint32_t) {
  SurfaceParts all;
  add(all, std::max(0.0, side == Side::outside ? p.z() : -p.z()), kOnlyFeature);
  return all;
}

double height(Side side, double distance, double radius) {
  return side == Side::outside ? distance - radius : radius - distance;
}

/// A proxy that was left behind holds the tool wherever it is.
double unless_entered(double distance, Side side, std::uint32_t entered) {
  return side == Side::outside && entered == kOnlyFeature ? 0.0 : distance;
}

SurfaceParts parts(const Sphere& sphere, Side side, const Vec3& p, std::uint32_t entered) {
  SurfaceParts all;
  const double near = std::max(0.0, height(side, p.norm(), sphere.radius));
  add(all, unless_entered(near, side, entered), kOnlyFeature);
  return all;
}

/// Side and ends are one smooth surface, but no patch: the one that the point is nearest to is
/// shown, the others begin behind their junction with it.
SurfaceParts parts(const Capsule& capsule, Side side, const Vec3& p, std::uint32_t entered) {
  SurfaceParts all;
  const double h = capsule.half_length;
  const Vec3 core(0.0, 0.0, std::clamp(p.z(), -h, h));
  const double near = std::max(0.0, height(side, (p - core).norm(), capsule.radius));
  add(all, unless_entered(near, side, entered), kOnlyFeature);
  if (!(h > 0.0)) return all;
  // From outside the way to the junction's plane and the way in are at right angles beside the
  // cylinder; from within only the longer of the two is sure.
  const double in = std::max(0.0, root(p.x(), p.y()) - capsule.radius);
  const auto behind = [&](double way) {
    add(all, side == Side::outside ? root(way, in) : std::max(way, near), kOnlyFeature, false);
  };
  if (std::abs(p.z()) <= h) {
    behind(h - p.z());
    behind(h + p.z());
  } else {
    behind(std::abs(p.z()) - h);
  }
  return all;
}

SurfaceParts parts(const Box& box, Side side, const Vec3& p, std::uint32_t entered) {
  SurfaceParts all;
  const Vec3& h = box.half_extents;
  const Vec3 out = (p.cwiseAbs() - h).cwiseMax(0.0);
  const double solid = out.norm();
  for (int face = 0; face < kBoxFaces; ++face) {
    const int axis = face / 2;
    const double inward = std::max(0.0, h[axis] - face_sign(face) * p[axis]);
    if (side == Side::inside) {
      add(all, inward, feature_of(face));
      continue;
    }
    Vec3 way = out;  // to what lies beyond this face and within the others
    way[axis] = inward;
    add_convex(all, way.norm(), solid, face, entered);
  }
  return all;
}

SurfaceParts parts(const Cylinder& cylinder, Side side, const Vec3& p, std::uint32_t entered) {
  SurfaceParts all;
  const double h = cylinder.half_length, distance = root(p.x(), p.y());
  const double to_side = std::max(0.0, cylinder.radius - distance);
  const double to_top = std::max(0.0, h - p.z()), to_bottom = std::max(0.0, h + p.z());
  if (side == Side::inside) {
    add(all, to_side, feature_of(kCylinderSide));
    add(all, to_top, feature_of(kCylinderTop));
    add(all, to_bottom, feature_of(kCylinderBottom));
    return all;
  }
  const double across = std::max(0.0, distance - cylinder.radius);
  const double along = std::max(0.0, std::abs(p.z()) - h);
  const double solid = root(across, along);
  add_convex(all, root(to_side, along), solid, kCylinderSide, entered);
  add_convex(all, root(to_top, across), solid, kCylinderTop, entered);
  add_convex(all, root(to_bottom, across), solid, kCylinderBottom, entered);
  return all;
}

/// Geometry of a patch, object frame.
struct Surface {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  bool joined = false;
};

Vec3 or_else(const Vec3& direction, const Vec3& other) {
  return direction.isZero(0.0) ? other : direction;
}

Surface round(Side side, const Vec3& core, const Vec3& outward, double radius) {
  const double sign = side == Side::outside ? 1.0 : -1.0;
  return {.point = core + radius * outward, .normal = sign * outward, .curvature = sign / radius};
}

/// The normal of a proxy that was left behind on another side than p; null: it is above p, or p
/// does not touch this face.
const Vec3* left_behind(Side side, int face, const Vec3& outward, const ContactMemory& memory) {
  constexpr double kRounding = 1e-9;
  const FeatureMemory& feature = memory.feature;
  if (side != Side::outside || !memory.touching || face_of(feature.feature) != face ||
      feature.side == 0 || length(Vec3(feature.normal - outward)) < kRounding)
    return nullptr;
  return &feature.normal;
}

Surface surface(const Plane&, Side side, const Vec3& p, int, const ContactMemory&) {
  return {.point = {p.x(), p.y(), 0.0}, .normal = {0.0, 0.0, side == Side::outside ? 1.0 : -1.0}};
}

Surface surface(const Sphere& sphere, Side side, const Vec3& p, int face,
                const ContactMemory& memory) {
  const Vec3 outward = or_else(direction(p), memory.feature.normal);
  const Vec3* behind = left_behind(side, face, outward, memory);
  return round(side, Vec3::Zero(), behind != nullptr ? *behind : outward, sphere.radius);
}

Vec3 across_axis(const Vec3& p, const ContactMemory& memory) {
  const Vec3 remembered(memory.feature.normal.x(), memory.feature.normal.y(), 0.0);
  return or_else(direction(Vec3(p.x(), p.y(), 0.0)), or_else(direction(remembered), Vec3::UnitX()));
}

Surface surface(const Capsule& capsule, Side side, const Vec3& p, int face,
                const ContactMemory& memory) {
  const double h = capsule.half_length;
  Vec3 core(0.0, 0.0, std::clamp(p.z(), -h, h));
  bool straight = h > 0.0 && std::abs(p.z()) <= h;
  Vec3 outward =
      straight ? across_axis(p, memory) : or_else(direction(Vec3(p - core)), memory.feature.normal);
  if (const Vec3* behind = left_behind(side, face, outward, memory)) {
    outward = *behind;
    core = RoundSolid{capsule.radius, h}.core_of(outward, p);
    straight = h > 0.0 && outward.z() == 0.0;
  }
  Surface s = round(side, core, outward, capsule.radius);
  if (straight) s.axis = Vec3::UnitZ();
  return s;
}

Surface surface(const Box& box, Side side, const Vec3& p, int face, const ContactMemory&) {
  const Vec3& h = box.half_extents;
  Surface s{.point = p.cwiseMax(-h).cwiseMin(h),
            .normal = (side == Side::outside ? 1.0 : -1.0) * face_sign(face) * Vec3::Unit(face / 2),
            .joined = side == Side::outside};
  s.point[face / 2] = face_sign(face) * h[face / 2];
  return s;
}

Surface surface(const Cylinder& cylinder, Side side, const Vec3& p, int face,
                const ContactMemory& memory) {
  const double h = cylinder.half_length, z = std::clamp(p.z(), -h, h);
  Surface s;
  if (face == kCylinderSide) {
    const Vec3 outward = across_axis(p, memory);
    const Vec3* behind = left_behind(side, face, outward, memory);
    s = round(side, Vec3(0.0, 0.0, z), behind != nullptr ? *behind : outward, cylinder.radius);
    s.axis = Vec3::UnitZ();
  } else {
    const double up = face == kCylinderTop ? 1.0 : -1.0;
    const double distance = root(p.x(), p.y());
    const double in = distance > cylinder.radius ? cylinder.radius / distance : 1.0;
    s.point = {in * p.x(), in * p.y(), up * h};
    s.normal = (side == Side::outside ? up : -up) * Vec3::UnitZ();
  }
  s.joined = side == Side::outside;
  return s;
}

/// touched: what a tool remembers that touches just this, else null.
SurfacePatch in_world(const Object& object, const Surface& s, std::uint32_t feature,
                      const ContactMemory* touched) {
  const Quaternion& to_world = object.pose.orientation;
  SurfacePatch patch;
  patch.point = object.pose.position + to_world * s.point;
  patch.normal = to_world * s.normal;
  patch.axis = to_world * s.axis;
  patch.curvature = s.curvature;
  patch.joined = s.joined;
  patch.material = object.material;
  patch.feature = feature;
  // Without friction there is no stick point.
  patch.anchor = patch.point;
  patch.touching = touched != nullptr;
  if (patch.touching && object.material.static_friction > 0.0) {
    patch.anchor = object.pose.position + to_world * touched->anchor;
    patch.slipping = touched->slipping;
  }
  return patch;
}

}  // namespace

SurfaceParts surface_parts(const Shape& shape, Side side, const Vec3& position,
                           std::uint32_t entered) noexcept {
  // get_if instead of visit: visit may throw.
  if (const auto* plane = std::get_if<Plane>(&shape)) return parts(*plane, side, position, entered);
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    return parts(*sphere, side, position, entered);
  if (const auto* box = std::get_if<Box>(&shape)) return parts(*box, side, position, entered);
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    return parts(*capsule, side, position, entered);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape))
    return parts(*cylinder, side, position, entered);
  return {};
}

SurfacePatch surface_patch(const Object& object, const Vec3& position, std::uint32_t feature,
                           const ContactMemory& memory) noexcept {
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 p = to_world.conjugate() * (position - object.pose.position);
  const Side side = object.felt_from;
  const int face = face_of(feature);
  Surface s;
  if (const auto* plane = std::get_if<Plane>(&object.shape))
    s = surface(*plane, side, p, face, memory);
  else if (const auto* sphere = std::get_if<Sphere>(&object.shape))
    s = surface(*sphere, side, p, face, memory);
  else if (const auto* box = std::get_if<Box>(&object.shape))
    s = surface(*box, side, p, face, memory);
  else if (const auto* capsule = std::get_if<Capsule>(&object.shape))
    s = surface(*capsule, side, p, face, memory);
  else if (const auto* cylinder = std::get_if<Cylinder>(&object.shape))
    s = surface(*cylinder, side, p, face, memory);

  return in_world(object, s, feature,
                  memory.touching && memory.feature.feature == feature ? &memory : nullptr);
}

SurfacePatch surface_patch(const Object& object, const FittedPatches& fitted, int index,
                           const ContactMemory& memory) noexcept {
  const FittedPatch& fit = fitted.patches[static_cast<std::size_t>(index)];
  const Surface s{.point = fit.point,
                  .normal = fit.normal,
                  .axis = fit.axis,
                  .curvature = fit.curvature,
                  .joined = fitted.joined};
  // The first is what the tool stands on.
  SurfacePatch patch =
      in_world(object, s, fit.feature, memory.touching && index == 0 ? &memory : nullptr);
  patch.offset = fitted.offset;
  patch.faceted = fitted.faceted;
  patch.rough = fitted.rough;
  return patch;
}

}  // namespace feltwire
