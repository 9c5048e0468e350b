#include <cmath>

#include "core/scene/validation.hpp"

namespace feltwire {
namespace {

constexpr double kMaxGuideForce = 1e6;  // [N]
constexpr const char* kMetres = " [m]";

/// Allows infinity: the file gave no value.
MaybeViolation may_be_endless(const char* field, double value) {
  if (value == std::numeric_limits<double>::infinity()) return std::nullopt;
  return positive(field, value, kMaxLength, kMetres);
}

MaybeViolation broken_place(const GuidePlace& place) {
  if (const auto* line = std::get_if<GuideLine>(&place))
    return may_be_endless("line.length", 2.0 * line->half_length);
  const auto* curve = std::get_if<GuideCurve>(&place);
  if (curve == nullptr)
    return on_primitive(
        place,
        [](const auto& solid) {
          MaybeViolation violation = check(Shape(solid));
          if (violation) violation->field = std::string(solid.kName) + "." + violation->field;
          return violation;
        },
        [] { return MaybeViolation(); });
  if (curve->points.size() < 2)
    return Violation{"curve.points", "are fewer than two; give the points that it runs through"};
  for (std::size_t i = 0; i < curve->points.size(); ++i)
    if (!(curve->points[i].cwiseAbs().maxCoeff() <= kMaxLength) || !curve->points[i].allFinite())
      return Violation{
          "curve.points[" + std::to_string(i) + "]",
          "must lie within " + number_text(kMaxLength) + " m of the origin; give metres"};
  return std::nullopt;
}

bool has_inside(const GuidePlace& place) {
  return std::get_if<GuidePoint>(&place) == nullptr && std::get_if<GuideLine>(&place) == nullptr &&
         std::get_if<GuideCurve>(&place) == nullptr;
}

Violation no_place(const char* action) {
  return {action, "needs a place; give one of point, line, curve, " + names_of_primitives(false)};
}
Violation no_inside(const char* action) {
  return {action,
          "acts inside its place, and this has no inside; give none of them for everywhere, or one "
          "of " +
              names_of_primitives(false)};
}

MaybeViolation broken_action(const Guide& guide) {
  const bool everywhere = std::get_if<Everywhere>(&guide.place) != nullptr;
  const bool inside = has_inside(guide.place);
  if (const auto* a = std::get_if<Attract>(&guide.action)) {
    if (everywhere) return no_place("attract");
    return first({positive("attract.stiffness", a->stiffness, kMaxStiffness, " [N/m]"),
                  not_negative("attract.damping", a->damping, kMaxDamping, " [N s/m]"),
                  may_be_endless("attract.range", a->range)});
  }
  if (const auto* k = std::get_if<KeepOut>(&guide.action)) {
    if (everywhere) return no_place("keep_out");
    return first({positive("keep_out.stiffness", k->stiffness, kMaxStiffness, " [N/m]"),
                  not_negative("keep_out.damping", k->damping, kMaxDamping, " [N s/m]"),
                  inside ? not_negative("keep_out.margin", k->margin, kMaxLength, kMetres)
                         : positive("keep_out.margin", k->margin, kMaxLength, kMetres)});
  }
  if (const auto* m = std::get_if<Magnet>(&guide.action)) {
    if (everywhere) return no_place("magnet");
    return positive("magnet.reach", m->reach, kMaxLength, kMetres);
  }
  if (const auto* v = std::get_if<Viscosity>(&guide.action)) {
    if (!inside) return no_inside("viscosity");
    return positive("viscosity.damping", v->damping, kMaxDamping, " [N s/m]");
  }
  const Vec3& force = std::get<ConstantForce>(guide.action).force;
  if (!inside) return no_inside("constant");
  if (force.allFinite() && force.cwiseAbs().maxCoeff() > 0.0) return std::nullopt;
  return Violation{
      "constant.force",
      "has no direction: all of [x, y, z] are zero, or one is not finite; give newtons"};
}

}  // namespace

MaybeViolation check(const Guide& guide) {
  if (auto violation = broken_place(guide.place)) return violation;
  if (auto violation = check(guide.pose)) return violation;
  if (auto violation = broken_action(guide)) return violation;
  return positive("max_force", guide.max_force, kMaxGuideForce, " [N]");
}

}  // namespace feltwire
