#include "core/local_model_extraction/patches.hpp"

namespace feltwire {
namespace {

/// touched: what a tool remembers that touches just this, else null.
SurfacePatch in_world(const Object& object, const PatchGeometry& s, std::uint32_t feature,
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
  return on_primitive(
      shape, [&](const auto& solid) { return solid.parts(side, position, entered); },
      [] { return SurfaceParts{}; });
}

SurfacePatch surface_patch(const Object& object, const Vec3& position, std::uint32_t feature,
                           const ContactMemory& memory) noexcept {
  const Quaternion& to_world = object.pose.orientation;
  const Vec3 p = to_world.conjugate() * (position - object.pose.position);
  const PatchGeometry s = on_primitive(
      object.shape,
      [&](const auto& solid) {
        return solid.patch(object.felt_from, p, static_cast<int>(feature) - 1, memory.feature,
                           memory.touching);
      },
      [] { return PatchGeometry{}; });
  return in_world(object, s, feature,
                  memory.touching && memory.feature.feature == feature ? &memory : nullptr);
}

SurfacePatch surface_patch(const Object& object, const FittedPatches& fitted, int index,
                           const ContactMemory& memory) noexcept {
  const FittedPatch& fit = fitted.patches[static_cast<std::size_t>(index)];
  const PatchGeometry s{.point = fit.point,
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
  patch.whole = fitted.whole;
  return patch;
}

}  // namespace feltwire
