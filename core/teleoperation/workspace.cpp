#include "core/teleoperation/workspace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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
  for (const KeepOutBody& body : other.keep_out()) both.add_body(body);
  for (std::size_t axis = 0; axis < 3; ++axis) both.locked[axis] |= other.locked[axis];
  both.turning_locked |= other.turning_locked;
  return both;
}

bool has_room(const Workspace& workspace, double inside) noexcept {
  constexpr int kTries = 200;
  constexpr int kCuts = 12;       // number of search points along each axis
  constexpr double kLeft = 1e-6;  // [m] accepted violation of a wall
  Workspace narrow = workspace;
  for (std::size_t i = 0; i < narrow.count; ++i) narrow.walls[i].distance += inside;
  const auto nearest = [&](Vec3 place) {
    for (int i = 0; i < kTries; ++i) place = nearest_in_front(place, narrow.view());
    return place;
  };
  const auto in_room = [&](const Vec3& place) {
    return std::ranges::all_of(
        narrow.view(), [&](const WorkspaceWall& wall) { return wall.clearance(place) >= -kLeft; });
  };
  const auto outside = [&](const Vec3& place) {
    return std::ranges::all_of(narrow.keep_out(), [&](const KeepOutBody& body) {
      return body.wall_at(place).clearance(place) >= inside - kLeft;
    });
  };
  const Vec3 first = nearest(Vec3::Zero());
  if (!in_room(first)) return false;
  if (outside(first)) return true;
  // The free space beside the bodies is either large or almost zero, so a coarse search is enough.
  Vec3 low, high;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vec3 far = 2.0 * Workspace::kFarthest * Vec3::Unit(axis);
    low[axis] = nearest(-far)[axis];
    high[axis] = nearest(far)[axis];
  }
  for (int n = 0; n < kCuts * kCuts * kCuts; ++n) {
    const int along_x = n % kCuts, along_y = n / kCuts % kCuts, along_z = n / (kCuts * kCuts);
    const Vec3 share(along_x, along_y, along_z);
    const Vec3 place =
        nearest_in_front(low + (high - low).cwiseProduct(share) / (kCuts - 1), narrow.view());
    if (in_room(place) && outside(place)) return true;
  }
  return false;
}

Vec3 nearest_in_front(const Vec3& point, std::span<const WorkspaceWall> walls) noexcept {
  constexpr int kSweeps = 50;
  // [m] correction along each normal
  std::array<double, Workspace::kMostWalls + Workspace::kMostBodies> moved{};
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
  // The robot's locked axes do not move. Along the free axes, a height h becomes h / l, where l is
  // the length of the normal's free part.
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
    // A movement along the free axes does not change the clearance of this wall.
    if (!(normal.length >= kHardlyFree)) continue;
    const double meant = (wall.distance - wall.normal.dot(held)) / normal.length;
    meant_[count_] = meant;
    walls_[count_] = {normal.direction, std::min(meant, normal.direction.dot(here.position))};
    ++count_;
  }
  depths_.fill(-std::numeric_limits<double>::infinity());
  face_bodies(here.position);
}

/// Returns the position, with each locked axis at its value from the start.
Vec3 WorkspaceLimit::unlocked(const Vec3& place) const noexcept {
  Vec3 kept = place;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (workspace_.locked[static_cast<std::size_t>(axis)]) kept[axis] = begun_.position[axis];
  return kept;
}

/// Computes the walls that replace the bodies, as seen from the permitted position `place`.
void WorkspaceLimit::face_bodies(const Vec3& place) noexcept {
  constexpr double kAcross = 1e-9;  // least length of the free part of a normal
  const Vec3 held = begun_.position - free_part(begun_.position);
  for (std::size_t i = 0; i < workspace_.body_count; ++i) {
    const WorkspaceWall full = workspace_.bodies[i].wall_at(place);
    depths_[i] = std::min(0.0, std::max(depths_[i], full.clearance(place)));
    const Polar<double> normal = polar(free_part(full.normal));
    const double distance = full.distance + depths_[i] - full.normal.dot(held);
    walls_[count_ + i] = normal.length > kAcross
                             ? WorkspaceWall{normal.direction, distance / normal.length}
                             : WorkspaceWall{Vec3::UnitZ(), -4.0 * Workspace::kFarthest};
  }
}

/// Returns the position nearest to `wanted` in front of all walls, on a straight path from a
/// permitted position `from`. Returns `from` if unfinished iterations would lead away from
/// `wanted`.
Vec3 WorkspaceLimit::slide(const Vec3& from, const Vec3& wanted) const noexcept {
  const Vec3 place = nearest_in_front(wanted, walls());
  // The walls bound a convex space. If `place` is outside this space, stop at the last point of the
  // path inside.
  double share = 1.0;
  for (const WorkspaceWall& wall : walls()) {
    const double clearance = wall.clearance(place);
    if (clearance >= -kRounding) continue;
    const double before = std::max(0.0, wall.clearance(from));
    share = std::min(share, before / (before - clearance));
  }
  const Vec3 reached = share < 1.0 ? Vec3(from + share * (place - from)) : place;
  return (reached - wanted).squaredNorm() <= (from - wanted).squaredNorm() ? reached : from;
}

Pose WorkspaceLimit::aim(const Pose& wanted) const noexcept {
  if (!wanted.position.allFinite() || !wanted.orientation.coeffs().allFinite()) return last_;
  return {nearest_in_front(unlocked(wanted.position), room()),
          workspace_.turning_locked ? begun_.orientation : wanted.orientation};
}

const Pose& WorkspaceLimit::keep(const Pose& wanted) noexcept {
  constexpr int kSlides = 16;  // largest number of slides along the bodies per sample
  if (!wanted.position.allFinite() || !wanted.orientation.coeffs().allFinite()) return last_;
  const Vec3 aim = unlocked(wanted.position);
  Vec3 place = slide(last_.position, aim);
  if (workspace_.body_count > 0) {
    Vec3 before = last_.position;
    for (int i = 1; i < kSlides && (place - before).norm() > kRounding; ++i) {
      face_bodies(place);
      before = place;
      place = slide(before, aim);
    }
    face_bodies(place);
  }
  last_.position = place;
  last_.orientation = workspace_.turning_locked ? begun_.orientation : wanted.orientation;
  for (std::size_t i = 0; i < count_; ++i) {
    double& distance = walls_[i].distance;
    distance = std::min(meant_[i], std::max(distance, walls_[i].normal.dot(place)));
  }
  return last_;
}

}  // namespace feltwire
