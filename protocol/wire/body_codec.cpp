#include "protocol/wire/body_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/wire/datagram.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {
namespace {

constexpr double kShort = 32767.0;  // largest value of a signed integer of 16 bits

/// Returns the nearest integer of 16 bits, or zero for NaN.
std::int16_t wire_short(double value) {
  if (std::isnan(value)) return 0;
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -kShort, kShort)));
}

/// Returns a lower triangular root of a symmetric matrix. The matrix is positive semidefinite
/// except for rounding errors.
Mat3 root_of(const Mat3& m) {
  Mat3 root = Mat3::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index k = 0; k <= i; ++k) {
      const double rest = m(i, k) - root.row(i).head(k).dot(root.row(k).head(k));
      if (i == k)
        root(i, i) = std::sqrt(std::max(0.0, rest));
      else
        root(i, k) = root(k, k) > 0.0 ? rest / root(k, k) : 0.0;
    }
  }
  return root;
}

wire::BodyPoint wire_point(const BodyPoint& p, double unit) {
  const Vec3 arm = p.arm / unit, normal = kShort * p.normal;
  const Mat3 root = root_of(p.spread) / unit;
  return {float32(p.distance),
          float32_above_zero(p.stiffness),
          wire_short(arm.x()),
          wire_short(arm.y()),
          wire_short(arm.z()),
          wire_short(normal.x()),
          wire_short(normal.y()),
          wire_short(normal.z()),
          wire_short(root(0, 0)),
          wire_short(root(1, 0)),
          wire_short(root(1, 1)),
          wire_short(root(2, 0)),
          wire_short(root(2, 1)),
          wire_short(root(2, 2)),
          p.patch};
}

BodyPoint part_of(const wire::BodyPoint& from, double unit) {
  Mat3 root;
  root << from.root_xx(), 0.0, 0.0, from.root_yx(), from.root_yy(), 0.0, from.root_zx(),
      from.root_zy(), from.root_zz();
  root *= unit;
  return {.arm = unit * Vec3(from.arm_x(), from.arm_y(), from.arm_z()),
          .spread = root * root.transpose(),
          .normal = Vec3(from.normal_x(), from.normal_y(), from.normal_z()) / kShort,
          .distance = from.distance(),
          .stiffness = from.stiffness(),
          .patch = from.patch()};
}

double unit_of(double radius) { return 2.0 * radius / kShort; }

// These functions return false for NaN.
bool above_zero(double x) { return x > 0.0 && std::isfinite(x); }
bool not_below_zero(double x) { return x >= 0.0 && std::isfinite(x); }

bool plausible(const BodyPatch& p) {
  return not_below_zero(p.dynamic_friction) && p.dynamic_friction <= p.static_friction &&
         not_below_zero(p.static_friction) && not_below_zero(p.viscous_friction) &&
         not_below_zero(p.damping_time) && p.velocity.allFinite();
}

bool plausible(const BodyPoint& p) {
  return std::isfinite(p.distance) && not_below_zero(p.stiffness) &&
         std::abs(p.normal.squaredNorm() - 1.0) <= kUnitTolerance;
}

}  // namespace

flatbuffers::Offset<wire::BodyModel> build(flatbuffers::FlatBufferBuilder& builder,
                                           const BodyModel& model) {
  const double unit = unit_of(float32(model.radius));
  std::array<wire::BodyPoint, kMaxBodyPoints> points;
  std::array<wire::BodyPatch, kMaxBodyPatches> patches;
  for (std::size_t i = 0; i < model.view().size(); ++i)
    points[i] = wire_point(model.points[i], unit);
  for (std::size_t i = 0; i < model.surfaces().size(); ++i) {
    const BodyPatch& p = model.patches[i];
    patches[i] = {float32(p.static_friction),  float32(p.dynamic_friction),
                  float32(p.viscous_friction), float32(p.damping_time),
                  wire_float(p.velocity),      p.object};
  }
  const auto wire_points = builder.CreateVectorOfStructs(points.data(), model.view().size());
  const auto wire_patches = builder.CreateVectorOfStructs(patches.data(), model.surfaces().size());
  const wire::Vec3d position = wire_double(model.tool.position);
  const wire::Quatd orientation = wire_double(model.tool.orientation);
  const ToolCoupling& c = model.coupling;
  return wire::CreateBodyModel(
      builder, model.scene, &position, &orientation, float32(model.reach), float32(model.turn),
      float32_above_zero(c.stiffness), float32_above_zero(c.rotational_stiffness),
      float32_above_zero(c.max_force), float32_above_zero(c.max_torque), float32(model.radius),
      model.slipping, wire_points, wire_patches, model.solids);
}

bool read(const wire::BodyModel& from, BodyModel& to) noexcept {
  to = {};
  const auto* points = from.points();
  const auto* patches = from.patches();
  const flatbuffers::uoffset_t count = points == nullptr ? 0 : points->size();
  const flatbuffers::uoffset_t patch_count = patches == nullptr ? 0 : patches->size();
  if (count > to.points.size() || patch_count > to.patches.size()) return false;
  to.scene = from.scene();
  to.solids = from.solids();
  to.tool = {value(*from.position()), value(*from.orientation())};
  to.reach = from.reach();
  to.turn = from.turn();
  to.coupling = {from.coupling_stiffness(), from.rotational_stiffness(), from.max_force(),
                 from.max_torque()};
  to.radius = from.radius();
  to.slipping = from.slipping();
  for (flatbuffers::uoffset_t i = 0; i < count; ++i) {
    to.points[i] = part_of(*points->Get(i), unit_of(to.radius));
    if (to.points[i].patch >= patch_count) return false;
  }
  for (flatbuffers::uoffset_t i = 0; i < patch_count; ++i) {
    const wire::BodyPatch& p = *patches->Get(i);
    to.patches[i] = {p.static_friction(), p.dynamic_friction(), p.viscous_friction(),
                     p.damping_time(),    value(p.velocity()),  p.object()};
  }
  to.count = static_cast<int>(count);
  to.patch_count = static_cast<int>(patch_count);
  return true;
}

bool plausible(const BodyModel& m) noexcept {
  const ToolCoupling& c = m.coupling;
  return m.tool.position.allFinite() && m.tool.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
         std::abs(m.tool.orientation.squaredNorm() - 1.0) <= kUnitTolerance &&
         not_below_zero(m.reach) && not_below_zero(m.turn) && above_zero(c.stiffness) &&
         above_zero(c.rotational_stiffness) && above_zero(c.max_force) &&
         above_zero(c.max_torque) && above_zero(m.radius) &&
         std::ranges::all_of(m.view(), [](const BodyPoint& p) { return plausible(p); }) &&
         std::ranges::all_of(m.surfaces(), [](const BodyPatch& p) { return plausible(p); });
}

}  // namespace feltwire
