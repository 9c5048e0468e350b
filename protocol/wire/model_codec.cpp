#include "protocol/wire/model_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/wire/datagram.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {
namespace {

constexpr std::uint8_t kFlagTouching = 1u << 0, kFlagSlipping = 1u << 1, kFlagJoined = 1u << 2,
                       kFlagFaceted = 1u << 3, kFlagRough = 1u << 4, kFlagWhole = 1u << 5;

wire::Patch wire_patch(const SurfacePatch& p, const Vec3& center) {
  const auto flags = (p.touching ? kFlagTouching : 0) | (p.slipping ? kFlagSlipping : 0) |
                     (p.joined ? kFlagJoined : 0) | (p.faceted ? kFlagFaceted : 0) |
                     (p.rough ? kFlagRough : 0) | (p.whole ? kFlagWhole : 0);
  const Material& m = p.material;
  return {wire_float(p.point - center),
          wire_float(p.normal),
          wire_float(p.axis),
          wire_float(p.velocity),
          wire_float(p.anchor - center),
          float32(p.curvature),
          float32(p.radius),
          float32_above_zero(m.stiffness),
          float32(m.damping),
          float32(m.static_friction),
          float32(m.dynamic_friction),
          float32(m.viscous_friction),
          p.feature,
          p.object,
          static_cast<std::uint8_t>(flags)};
}

void read(const wire::Patch& from, const Vec3& center, SurfacePatch& to) {
  to.point = center + value(from.point());
  to.normal = value(from.normal());
  to.axis = value(from.axis());
  to.velocity = value(from.velocity());
  to.anchor = center + value(from.anchor());
  to.curvature = from.curvature();
  to.radius = from.radius();
  to.material = {from.stiffness(), from.damping(), from.static_friction(), from.dynamic_friction(),
                 from.viscous_friction()};
  to.object = from.object();
  to.feature = from.feature();
  to.touching = (from.flags() & kFlagTouching) != 0;
  to.slipping = (from.flags() & kFlagSlipping) != 0;
  to.joined = (from.flags() & kFlagJoined) != 0;
  to.faceted = (from.flags() & kFlagFaceted) != 0;
  to.rough = (from.flags() & kFlagRough) != 0;
  to.whole = (from.flags() & kFlagWhole) != 0;
}

/// Returns true if the numbers of a patch are in their valid ranges. NaN fails all these
/// comparisons.
bool plausible(const SurfacePatch& p) {
  const Material& m = p.material;
  return p.point.allFinite() && unit_length(p.normal) &&
         (p.axis.isZero(0.0) || unit_length(p.axis)) && p.velocity.allFinite() &&
         p.anchor.allFinite() && std::isfinite(p.curvature) && p.radius >= 0.0 &&
         std::isfinite(p.offset) && m.stiffness > 0.0 && std::isfinite(m.stiffness) &&
         m.damping >= 0.0 && std::isfinite(m.damping) && m.dynamic_friction >= 0.0 &&
         m.dynamic_friction <= m.static_friction && std::isfinite(m.static_friction) &&
         m.viscous_friction >= 0.0 && std::isfinite(m.viscous_friction);
}

}  // namespace

bool unit_length(const Vec3& v) noexcept {
  return std::abs(v.squaredNorm() - 1.0) <= kUnitTolerance;
}

flatbuffers::Offset<wire::LocalModel> build(flatbuffers::FlatBufferBuilder& builder,
                                            const LocalModel& model) {
  std::array<wire::Patch, kMaxPatches> patches;
  const auto count = static_cast<std::size_t>(std::clamp(model.count, 0, kMaxPatches));
  for (std::size_t i = 0; i < count; ++i) patches[i] = wire_patch(model.patches[i], model.center);
  const wire::Vec3d center = wire_double(model.center);
  const auto vector = builder.CreateVectorOfStructs(patches.data(), count);
  std::array<float, kMaxPatches> offsets;
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    offsets[i] = float32(model.patches[i].offset);
    any |= offsets[i] != 0.0F;
  }
  const auto offset_vector = any ? builder.CreateVector(offsets.data(), count)
                                 : flatbuffers::Offset<flatbuffers::Vector<float>>{};
  return wire::CreateLocalModel(builder, &center, float32(model.reach), vector, offset_vector,
                                model.scene, model.surfaces);
}

bool read(const wire::LocalModel& from, LocalModel& to) noexcept {
  to.center = value(*from.center());
  to.reach = from.reach();
  const auto* patches = from.patches();
  const flatbuffers::uoffset_t count = patches == nullptr ? 0 : patches->size();
  if (count > to.patches.size()) return false;
  const auto* offsets = from.offsets();
  if (offsets != nullptr && offsets->size() != count) return false;
  for (flatbuffers::uoffset_t i = 0; i < count; ++i) {
    read(*patches->Get(i), to.center, to.patches[i]);
    to.patches[i].offset = offsets != nullptr ? offsets->Get(i) : 0.0F;
    if (to.patches[i].whole && from.surfaces() == 0) return false;
  }
  to.count = static_cast<int>(count);
  to.scene = from.scene();
  to.surfaces = from.surfaces();
  return true;
}

bool plausible(const LocalModel& model) noexcept {
  return model.center.allFinite() && model.reach >= 0.0 &&
         std::ranges::all_of(model.view(), [](const SurfacePatch& p) { return plausible(p); });
}

}  // namespace feltwire
