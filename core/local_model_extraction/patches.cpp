#include "core/local_model_extraction/patches.hpp"

#include <algorithm>

namespace feltwire {
namespace {

SurfacePatch in_world(const Object& object, const PatchGeometry& s, std::uint32_t feature) {
  const Quaternion& to_world = object.pose.orientation;
  SurfacePatch patch;
  patch.point = object.pose.position + to_world * s.point;
  patch.normal = to_world * s.normal;
  patch.axis = to_world * s.axis;
  patch.curvature = s.curvature;
  patch.joined = s.joined;
  patch.material = object.material;
  patch.feature = feature;
  // A surface without friction has no stick point, so the anchor is the patch's point.
  patch.anchor = patch.point;
  return patch;
}

template <Primitive Solid>
Grown<Solid> grown_by(const Solid& solid, Side side, double ball) {
  return ball > 0.0 ? solid.grown(side, ball) : Grown<Solid>{solid};
}

template <Primitive Solid>
SurfaceParts parts_of(const Grown<Solid>& grown, Side side, const Vec3& p, std::uint32_t entered) {
  SurfaceParts all = grown.solid.parts(side, p - grown.middle, entered);
  for (SurfacePart& part : all.parts) part.distance = std::max(0.0, part.distance - grown.round);
  return all;
}

struct GrownPatch {
  PatchGeometry patch;
  double offset = 0.0;  // [m] distance from the patch to the contact surface
};

template <Primitive Solid>
GrownPatch patch_of(const Grown<Solid>& grown, Side side, const Vec3& p, std::uint32_t feature,
                    const ContactMemory& memory) {
  GrownPatch of{grown.solid.patch(side, p - grown.middle, static_cast<int>(feature) - 1,
                                  memory.feature, memory.touching),
                grown.round};
  of.patch.point += grown.middle;
  return of;
}

}  // namespace

SurfaceParts surface_parts(const Shape& shape, Side side, const Vec3& position,
                           std::uint32_t entered, double ball) noexcept {
  return on_primitive(
      shape,
      [&](const auto& solid) {
        if (!(ball > 0.0)) return solid.parts(side, position, entered);
        return parts_of(solid.grown(side, ball), side, position, entered);
      },
      [] { return SurfaceParts{}; });
}

SurfacePatch surface_patch(const Object& object, const Vec3& position, std::uint32_t feature,
                           const ContactMemory& memory, double ball) noexcept {
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 p = to_world.conjugate() * (position - object.pose.position);
  const Side side = object.felt_from;
  const GrownPatch of = on_primitive(
      object.shape,
      [&](const auto& solid) {
        return patch_of(grown_by(solid, side, ball), side, p, feature, memory);
      },
      [] { return GrownPatch{}; });
  SurfacePatch patch = in_world(object, of.patch, feature);
  patch.offset = of.offset;
  if (memory.touching && memory.feature.feature == feature) set_touched(patch, object, memory);
  return patch;
}

SurfacePatch surface_patch(const Object& object, const FittedPatches& fitted, int index,
                           const ContactMemory& memory) noexcept {
  const FittedPatch& fit = fitted.patches[static_cast<std::size_t>(index)];
  const PatchGeometry s{.point = fit.point,
                        .normal = fit.normal,
                        .axis = fit.axis,
                        .curvature = fit.curvature,
                        .joined = fitted.joined};
  SurfacePatch patch = in_world(object, s, fit.feature);
  // The tool touches the first patch.
  if (memory.touching && index == 0) set_touched(patch, object, memory);
  patch.offset = fitted.offset;
  patch.faceted = fitted.faceted;
  patch.rough = fitted.rough;
  patch.whole = fitted.whole;
  return patch;
}

void set_touched(SurfacePatch& patch, const Object& object, const ContactMemory& memory) noexcept {
  patch.touching = true;
  if (!(object.material.static_friction > 0.0)) return;
  patch.anchor = object.pose.position + object.pose.orientation * memory.anchor;
  patch.slipping = memory.slipping;
}

}  // namespace feltwire
