#include "core/guidance/guide.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

/// Returns the elastic force `force` [N] along `away` and a damping force. Each part and their sum
/// are at most `most` [N]. The damping uses only the rest of `most`, so that the elastic part
/// depends on the position alone.
Command along_way(const Vec3& away, double force, double damping, const Vec3& velocity,
                  double most) {
  Command command;
  force = std::clamp(force, -most, most);
  command.elastic = force * away;
  const double room = most - std::abs(force);
  command.frictional = std::clamp(-damping * velocity.dot(away), -room, room) * away;
  return command;
}

/// Returns a factor for the force. It is 1 up to half of the range, and then falls linearly to 0.
double fade(double distance, double range) {
  constexpr double kWhole = 0.5;
  if (distance <= kWhole * range) return 1.0;
  return std::max(0.0, (1.0 - distance / range) / (1.0 - kWhole));
}

Command attract(const Attract& spring, const ClosestPoint& closest, const Vec3& velocity,
                double most) {
  const double share = fade(closest.distance, spring.range);
  return along_way(closest.away, -share * std::min(spring.stiffness * closest.distance, most),
                   share * spring.damping, velocity, most);
}

Command keep_out(const KeepOut& spring, const ClosestPoint& closest, const Vec3& velocity,
                 double most) {
  const double depth = spring.margin - closest.distance;
  if (!(depth > 0.0)) return {};
  Command command =
      along_way(closest.away, spring.stiffness * depth, spring.damping, velocity, most);
  // When the hand leaves, the damping must not exceed the spring force. Otherwise the damping would
  // hold the hand back.
  if (command.force().dot(closest.away) < 0.0) command.frictional = -command.elastic;
  return command;
}

Command magnet(const Magnet& field, const ClosestPoint& closest, double most) {
  const double x = closest.distance / field.reach;
  return along_way(closest.away, -most * 2.0 * x / (1.0 + x * x), 0.0, Vec3::Zero(), most);
}

Command viscosity(const Viscosity& medium, const Vec3& velocity, double most) {
  Command command;
  const Polar<double> moving = polar(velocity);
  command.frictional = -std::min(medium.damping * moving.length, most) * moving.direction;
  return command;
}

Command constant(const ConstantForce& field, double most) {
  Command command;
  const Polar<double> force = polar(field.force);
  command.elastic = std::min(force.length, most) * force.direction;
  return command;
}

/// Returns the distance of the tool from the guide's `place` and the unit vector away from it, in
/// the world frame. `Everywhere` contains every point.
ClosestPoint foot_at(const Guide& guide, const Vec3& position) {
  if (std::get_if<Everywhere>(&guide.place) != nullptr) return {Vec3::Zero(), -1.0};
  ClosestPoint at = closest_point(
      guide.place, guide.pose.orientation.conjugate() * (position - guide.pose.position));
  at.away = guide.pose.orientation * at.away;
  return at;
}

bool has_an_end(const GuidePlace& place) {
  return on_primitive(
      place, [](const auto& solid) { return is_bounded(solid); }, [] { return true; });
}

}  // namespace

Command guide_force(const Guide& guide, const Tool& tool) noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite()) [[unlikely]]
    return {};
  ClosestPoint at = foot_at(guide, tool.position);
  const Vec3& v = tool.velocity;
  const double most = guide.max_force;
  if (const auto* out = std::get_if<KeepOut>(&guide.action)) return keep_out(*out, at, v, most);
  const bool inside = at.distance < 0.0;
  if (const auto* medium = std::get_if<Viscosity>(&guide.action))
    return inside ? viscosity(*medium, v, most) : Command{};
  if (const auto* field = std::get_if<ConstantForce>(&guide.action))
    return inside ? constant(*field, most) : Command{};

  // A bounded solid attracts only from outside. An unbounded solid (a plane) attracts from both
  // sides.
  if (inside && has_an_end(guide.place)) return {};
  if (inside) at = {-at.away, -at.distance};
  if (const auto* spring = std::get_if<Attract>(&guide.action))
    return attract(*spring, at, v, most);
  if (const auto* field = std::get_if<Magnet>(&guide.action)) return magnet(*field, at, most);
  return {};
}

double begins(const Guide& guide, const Vec3& position) noexcept {
  const double distance = foot_at(guide, position).distance;
  if (std::get_if<Magnet>(&guide.action) != nullptr) return 0.0;
  if (const auto* spring = std::get_if<Attract>(&guide.action))
    // Inside a solid, the depth counts as the distance.
    return std::max(0.0, std::abs(distance) - spring->range);
  if (const auto* spring = std::get_if<KeepOut>(&guide.action))
    return std::max(0.0, distance - spring->margin);
  return std::max(0.0, distance);
}

bool needs_velocity(const Guide& guide) noexcept {
  if (const auto* spring = std::get_if<Attract>(&guide.action)) return spring->damping > 0.0;
  if (const auto* spring = std::get_if<KeepOut>(&guide.action)) return spring->damping > 0.0;
  return std::get_if<Viscosity>(&guide.action) != nullptr;
}

double stiffness(const Guide& guide) noexcept {
  if (const auto* spring = std::get_if<Attract>(&guide.action)) {
    // A fading force falls over half of the range, possibly more steeply than the spring force
    // rises.
    const double falling = 2.0 * std::min(guide.max_force, spring->stiffness * spring->range);
    return std::isinf(spring->range) ? spring->stiffness
                                     : std::max(spring->stiffness, falling / spring->range);
  }
  if (const auto* spring = std::get_if<KeepOut>(&guide.action)) return spring->stiffness;
  if (const auto* field = std::get_if<Magnet>(&guide.action))
    return 2.0 * guide.max_force / field->reach;  // slope of the force at distance 0
  return 0.0;
}

}  // namespace feltwire
