#include "core/teleoperation/workspace.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kRounding = 1e-12;  // [m]

}  // namespace

void Workspace::add_box(const Vec3& low, const Vec3& high) noexcept {
  for (int axis = 0; axis < 3; ++axis) {
    add({Vec3::Unit(axis), low[axis]});
    add({-Vec3::Unit(axis), -high[axis]});
  }
}

Workspace joined(const Workspace& one, const Workspace& other) noexcept {
  Workspace both = one;
  for (const WorkspaceWall& wall : other.view()) both.add(wall);
  for (std::size_t axis = 0; axis < 3; ++axis) both.locked[axis] |= other.locked[axis];
  both.turning_locked |= other.turning_locked;
  return both;
}

bool has_room(const Workspace& workspace, double inside) noexcept {
  constexpr int kTries = 200;
  constexpr double kLeft = 1e-6;  // [m]
  Workspace narrow = workspace;
  for (std::size_t i = 0; i < narrow.count; ++i) narrow.walls[i].distance += inside;
  Vec3 place = Vec3::Zero();
  for (int i = 0; i < kTries; ++i) place = nearest_in_front(place, narrow.view());
  return std::ranges::all_of(
      narrow.view(), [&](const WorkspaceWall& wall) { return wall.clearance(place) >= -kLeft; });
}

Vec3 nearest_in_front(const Vec3& point, std::span<const WorkspaceWall> walls) noexcept {
  constexpr int kSweeps = 50;
  std::array<double, Workspace::kMostWalls> moved{};  // [m] along each normal
  Vec3 place = point;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double largest = 0.0;
    for (std::size_t i = 0; i < walls.size() && i < moved.size(); ++i) {
      double back = std::min(moved[i], walls[i].clearance(place));
      if (std::abs(back) <= kRounding) back = 0.0;
      moved[i] -= back;
      place -= back * walls[i].normal;
      largest = std::max(largest, std::abs(back));
    }
    if (largest == 0.0) break;
  }
  return place;
}

Vec3 WorkspaceLimit::free_part(const Vec3& movement) const noexcept {
  Vec3 part = movement;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (workspace_.locked[axis]) part[static_cast<Eigen::Index>(axis)] = 0.0;
  return part;
}

RemoteContact WorkspaceLimit::free_part(const RemoteContact& contact) const noexcept {
  if (contact.surface == 0) return contact;
  const Polar<double> normal = polar(free_part(contact.normal));
  if (contact.normal == free_part(contact.normal)) return contact;
  if (!(normal.length >= kHardlyFree)) return {};
  // The height along the free axes is that of the robot, whose locked axes stand still: h' = h / l.
  const Vec3 held = begun_.position - free_part(begun_.position);
  const double height = (free_part(contact.point) + held - contact.point).dot(contact.normal);
  RemoteContact seen = contact;
  seen.normal = normal.direction;
  seen.point = contact.point - (height / normal.length) * normal.direction;
  seen.velocity = (contact.velocity.dot(contact.normal) / normal.length) * normal.direction;
  seen.stiffness = contact.stiffness * normal.length * normal.length;
  return seen;
}

void WorkspaceLimit::begin(const Pose& here) noexcept {
  begun_ = last_ = here;
  count_ = 0;
  const Vec3 held = here.position - free_part(here.position);
  for (const WorkspaceWall& wall : workspace_.view()) {
    const Polar<double> normal = polar(free_part(wall.normal));
    if (!(normal.length >= kHardlyFree)) continue;  // the locked axes decide about it
    const double meant = (wall.distance - wall.normal.dot(held)) / normal.length;
    meant_[count_] = meant;
    walls_[count_] = {normal.direction, std::min(meant, normal.direction.dot(here.position))};
    ++count_;
  }
}

const Pose& WorkspaceLimit::keep(const Pose& wanted) noexcept {
  if (!wanted.position.allFinite() || !wanted.orientation.coeffs().allFinite()) return last_;
  Vec3 place = wanted.position;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (workspace_.locked[static_cast<std::size_t>(axis)]) place[axis] = begun_.position[axis];
  place = nearest_in_front(place, walls());
  // The room is convex: between a place in it and one outside there is the last one in it.
  double share = 1.0;
  for (const WorkspaceWall& wall : walls()) {
    const double clearance = wall.clearance(place);
    if (clearance >= -kRounding) continue;
    const double before = std::max(0.0, wall.clearance(last_.position));
    share = std::min(share, before / (before - clearance));
  }
  if (share < 1.0) place = last_.position + share * (place - last_.position);
  last_.position = place;
  last_.orientation = workspace_.turning_locked ? begun_.orientation : wanted.orientation;
  for (std::size_t i = 0; i < count_; ++i) {
    double& distance = walls_[i].distance;
    distance = std::min(meant_[i], std::max(distance, walls_[i].normal.dot(place)));
  }
  return last_;
}

}  // namespace feltwire
