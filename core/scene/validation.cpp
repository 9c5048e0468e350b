#include "core/scene/validation.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/base/written_number.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

/// `least` in words, with the unit in its brackets.
MaybeViolation out_of_range(const char* field, double value, const std::string& least, double most,
                            const std::string& unit) {
  if (std::isnan(value)) return Violation{field, "is not given; give a number " + least + unit};
  if (value > most)
    return Violation{field, "must be at most " + number_text(most) + unit + ", is " +
                                number_text(value) + "; check the unit"};
  return Violation{
      field, "must be " + least + unit + ", is " + number_text(value) + "; give a larger number"};
}

}  // namespace

MaybeViolation positive(const char* field, double value, double most, const char* unit) {
  if (value > 0.0 && value <= most) return std::nullopt;
  return out_of_range(field, value, "above zero", most, unit);
}

MaybeViolation not_negative(const char* field, double value, double most, const char* unit) {
  if (value >= 0.0 && value <= most) return std::nullopt;
  return out_of_range(field, value, "at least zero", most, unit);
}

MaybeViolation first(std::initializer_list<MaybeViolation> found) {
  for (const MaybeViolation& f : found)
    if (f) return f;
  return std::nullopt;
}

namespace {

struct ShapeRules {
  MaybeViolation operator()(const Primitive auto& solid) const {
    MaybeViolation violation;
    solid.lengths(solid, [&](const Length& length, double value) {
      if (violation) return;
      const double given = value / length.share, most = std::min(length.most, kMaxLength);
      violation = length.may_be_zero ? not_negative(length.name, given, most, " [m]")
                                     : positive(length.name, given, most, " [m]");
    });
    return violation;
  }
  MaybeViolation operator()(const Mesh& m) const {
    if (!m.surface) return Violation{"mesh", "has no surface; load one"};
    const TriangleMesh& mesh = m.surface->mesh();
    const double size = 2.0 * mesh.half_extents().maxCoeff();
    if (!(size <= kMaxLength && mesh.origin().cwiseAbs().maxCoeff() <= kMaxLength))
      return Violation{"scale", "makes a surface of " + number_text(size) + " m at " +
                                    number_text(mesh.origin().cwiseAbs().maxCoeff()) +
                                    " m from the origin; check the unit"};
    return first({positive("scale: the size of the surface", size, kMaxLength, " [m]"),
                  not_negative("radius", m.surface->options().radius, kMaxLength, " [m]")});
  }
  MaybeViolation operator()(const Grid& g) const {
    if (g.field) return std::nullopt;
    return Violation{"grid", "has no field; sample a solid"};
  }
};

MaybeViolation coordinate(const char* field, double value) {
  if (std::abs(value) <= kMaxLength) return std::nullopt;
  return Violation{field, "must lie within " + number_text(kMaxLength) + " m of the origin, is " +
                              number_text(value) + "; give metres"};
}

MaybeViolation coordinates(const Vec3& position) {
  return first({coordinate("position.x", position.x()), coordinate("position.y", position.y()),
                coordinate("position.z", position.z())});
}

}  // namespace

void make_unit(Quaternion& orientation) {
  auto& coefficients = orientation.coeffs();
  coefficients /= coefficients.cwiseAbs().maxCoeff();  // now no square over- or underflows
  coefficients.normalize();
}

std::string number_text(double value) { return shortest_text(value); }

MaybeViolation check(const Shape& shape) { return std::visit(ShapeRules{}, shape); }

MaybeViolation check(const Material& m) {
  if (auto violation =
          first({positive("stiffness", m.stiffness, kMaxStiffness, " [N/m]"),
                 not_negative("damping", m.damping, kMaxDamping, " [N s/m]"),
                 not_negative("static_friction", m.static_friction, kMaxFrictionCoefficient, ""),
                 not_negative("dynamic_friction", m.dynamic_friction, kMaxFrictionCoefficient, ""),
                 not_negative("viscous_friction", m.viscous_friction, kMaxDamping, " [N s/m]")}))
    return violation;
  if (m.dynamic_friction <= m.static_friction) return std::nullopt;
  return Violation{"dynamic_friction",
                   "must not exceed static_friction = " + number_text(m.static_friction) + ", is " +
                       number_text(m.dynamic_friction) + "; lower it or raise the other"};
}

MaybeViolation check(const Pose& pose) {
  if (auto violation = coordinates(pose.position)) return violation;
  const double largest = pose.orientation.coeffs().cwiseAbs().maxCoeff();
  if (pose.orientation.coeffs().allFinite() && largest > 0.0) return std::nullopt;
  return Violation{"orientation",
                   "is no rotation: all of [w, x, y, z] are zero or one is not finite; "
                   "leave it out or give a quaternion"};
}

MaybeViolation check(const Start& start) {
  if (auto violation = coordinates(start.position)) return violation;
  if (start.normal.allFinite() && length(start.normal) > 0.0) return std::nullopt;
  return Violation{"normal",
                   "has no direction: all of [x, y, z] are zero; leave it out or give a normal"};
}

MaybeViolation check(const KeepOutBody& body) {
  constexpr double kMost = Workspace::kFarthest;
  if (auto violation = check(body.pose)) return violation;
  if (!(body.pose.position.cwiseAbs().maxCoeff() <= kMost))
    return Violation{"position", "is farther than 1000 m from the robot's origin; move it"};
  const Vec3 size = 2.0 * body.half;
  if (auto violation = first({not_negative("size.x", size.x(), kMost, " [m]"),
                              not_negative("size.y", size.y(), kMost, " [m]"),
                              not_negative("size.z", size.z(), kMost, " [m]")}))
    return violation;
  if (body.radius >= KeepOutBody::kLeastRadius && body.radius <= kMost) return std::nullopt;
  return Violation{"radius", "is " + number_text(body.radius) + "; give " +
                                 number_text(KeepOutBody::kLeastRadius) + " to " +
                                 number_text(kMost) + " m"};
}

MaybeViolation check(const Alignment& aligned) {
  if (auto violation = check(Pose{Vec3::Zero(), aligned.offset})) return violation;
  constexpr double kMost = Alignment::kLargestGate;
  if (aligned.gate > 0.0 && aligned.gate <= kMost) return std::nullopt;
  return Violation{"gate", "is " + number_text(aligned.gate) + "; give an angle above 0, at most " +
                               number_text(kMost) + " rad"};
}

MaybeViolation check(const ArmControl& arm) {
  const struct {
    const char* field;
    double value;
    bool may_be_zero;
  } numbers[] = {{"stiffness", arm.stiffness, false},
                 {"turning_stiffness", arm.turning_stiffness, false},
                 {"damping_ratio", arm.damping_ratio, false},
                 {"posture_stiffness", arm.posture_stiffness, true},
                 {"largest_pull", arm.largest_pull, false},
                 {"largest_turn", arm.largest_turn, false},
                 {"stop_force", arm.stop_force, false},
                 {"stop_torque", arm.stop_torque, false},
                 {"noise", arm.noise, true},
                 {"torque_noise", arm.torque_noise, true},
                 {"gripper", arm.gripper.value_or(0.0), true}};
  for (const auto& [field, value, may_be_zero] : numbers)
    if (!(std::isfinite(value) && (value > 0.0 || (may_be_zero && value == 0.0))))
      return Violation{field, "is " + number_text(value) + "; give a finite number " +
                                  (may_be_zero ? "of 0 or more" : "above 0")};
  return std::nullopt;
}

MaybeViolation check(const RemoteSeat& seat) {
  const struct {
    const char* field;
    double value, most;
  } numbers[] = {{"scale", seat.scale, 100.0},
                 {"force_scale", seat.force_scale, 100.0},
                 {"speed", seat.speed, 10.0},
                 {"force", seat.force, 1e4},
                 {"workspace.stiffness", seat.wall_stiffness, kMaxStiffness},
                 {"workspace.depth", seat.wall_depth, kMaxWallDepth}};
  for (const auto& [field, value, most] : numbers)
    if (!(value > 0.0 && value <= most))
      return Violation{field, "is " + number_text(value) + "; give a number above 0, at most " +
                                  number_text(most)};
  if (seat.workspace.count > Workspace::kMostGiven)
    return Violation{"workspace.walls",
                     "are " + std::to_string(seat.workspace.count) + "; give 16 at most"};
  if (seat.workspace.body_count > Workspace::kMostBodiesGiven)
    return Violation{"workspace.keep_out",
                     "are " + std::to_string(seat.workspace.body_count) + "; give 8 at most"};
  for (const KeepOutBody& body : seat.workspace.keep_out())
    if (auto violation = check(body))
      return Violation{"workspace.keep_out." + violation->field, violation->message};
  if (seat.aligned) {
    if (auto violation = check(*seat.aligned))
      return Violation{"aligned." + violation->field, violation->message};
    if (seat.workspace.turning_locked)
      return Violation{
          "aligned", "has no meaning where workspace.lock has \"rotation\"; leave out one of both"};
  }
  if (seat.arm)
    if (auto violation = check(*seat.arm))
      return Violation{"arm." + violation->field, violation->message};
  if (has_room(seat.workspace, seat.wall_depth * seat.scale)) return std::nullopt;
  return Violation{"workspace",
                   "leaves no place that is " + number_text(seat.wall_depth * seat.scale) +
                       " m (depth times scale) inside of all its walls and outside of all "
                       "that it keeps out of; move them apart, turn a normal that points outwards, "
                       "make a body smaller, or lock an axis instead"};
}

MaybeViolation broken_name(const std::string& name) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  if (std::any_of(name.begin(), name.end(), is_control))
    return Violation{"name", "holds a line break or another control character; remove it"};
  if (!name.empty() && name.size() <= kMaxNameLength) return std::nullopt;
  return Violation{"name", "must be 1 to " + std::to_string(kMaxNameLength) + " bytes long, is " +
                               std::to_string(name.size()) + "; choose a short name"};
}

}  // namespace feltwire
