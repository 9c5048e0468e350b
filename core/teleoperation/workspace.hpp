#pragma once
// Limits of a robot's target: walls, bodies that it stays out of, and locked axes.

#include <array>
#include <cstddef>
#include <span>

#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/keep_out_body.hpp"

namespace feltwire {

/// A scene has at most so many seats for robots.
inline constexpr std::size_t kMostSeats = 4;

/// Limits of a robot's target in the robot's frame. All walls together bound a convex room, in
/// which there may be bodies that the target stays out of. A locked axis keeps the value that it
/// had when the hand engaged.
struct Workspace {
  static constexpr std::size_t kMostGiven = 16;       // walls of a scene's seat, and of a robot
  static constexpr std::size_t kMostBodiesGiven = 8;  // the same of bodies
  static constexpr std::size_t kMostWalls = 2 * kMostGiven;
  static constexpr std::size_t kMostBodies = 2 * kMostBodiesGiven;
  static constexpr double kFarthest = 1e3;  // [m] of a wall or a body from the origin

  std::array<WorkspaceWall, kMostWalls> walls{};
  std::size_t count = 0;
  std::array<KeepOutBody, kMostBodies> bodies{};
  std::size_t body_count = 0;
  std::array<bool, 3> locked{};  // movement along x, y, z
  bool turning_locked = false;

  std::span<const WorkspaceWall> view() const noexcept { return {walls.data(), count}; }
  std::span<const KeepOutBody> keep_out() const noexcept { return {bodies.data(), body_count}; }
  bool limits() const noexcept {
    return count > 0 || body_count > 0 || locked[0] || locked[1] || locked[2] || turning_locked;
  }
  /// Precondition: there are fewer than kMostWalls, and the wall's normal is unit.
  void add(const WorkspaceWall& wall) noexcept { walls[count++] = wall; }
  /// Precondition: there are fewer than kMostBodies, and the body is valid.
  void add_body(const KeepOutBody& body) noexcept { bodies[body_count++] = body; }
  /// The six walls of a box, from `low` to `high` [m] on each axis. Precondition: room for six.
  void add_box(const Vec3& low, const Vec3& high) noexcept;
};

/// Both workspaces apply. Precondition: neither has more than kMostGiven walls or more than
/// kMostBodiesGiven bodies.
Workspace joined(const Workspace& one, const Workspace& other) noexcept;

/// Whether a place is found that is at least `inside` [m] in front of every wall and from every
/// body. Thin wedges, and narrow gaps between bodies that fill the rest, count as no place.
bool has_room(const Workspace& workspace, double inside) noexcept;

/// Returns the nearest point to `point` that is in front of all walls, by Hildreth's row action:
/// each wall in turn moves the point to itself, or takes back its earlier movement. It is exact for
/// walls at right angles. If the sweeps do not suffice (acute wedges, no such point) the result may
/// be behind a wall, or not quite the nearest. A point in front of all walls is returned unchanged.
Vec3 nearest_in_front(const Vec3& point, std::span<const WorkspaceWall> walls) noexcept;

/// Keeps a target within a workspace, from an engagement on. If the target is behind a wall or in a
/// body then, it stays, so that the first step is zero; it may come nearer to the outside, and does
/// not go back. So for every wanted target and every time: the target is not farther behind any
/// wall and not deeper in any body than it was, and a locked axis keeps its first value.
///
/// Each step is a chain of straight slides. A slide stays in front of the walls that the bodies
/// have where it begins, so it does not cross a body, however thin. The target goes along a body as
/// long as that leads nearer to the wanted place; it does not look for a way around.
///
/// No function allocates, throws or reads a clock.
class WorkspaceLimit {
 public:
  explicit WorkspaceLimit(const Workspace& workspace = {}) : workspace_(workspace) { begin({}); }

  /// The hand engages while the target is at `here`. Precondition: it is finite.
  void begin(const Pose& here) noexcept;
  /// Returns the allowed target that is reached on the way to the wanted one; without bodies it is
  /// the nearest. On the free axes it is not farther from the wanted target than the last one was.
  /// A wanted target that is not finite changes nothing.
  const Pose& keep(const Pose& wanted) noexcept;
  /// Returns the nearest target that the present walls and the locked axes allow, bodies aside.
  /// Changes nothing. Returns the last target if the wanted one is not finite.
  Pose aim(const Pose& wanted) const noexcept;

  /// Returns the part of a movement along the axes that are not locked.
  Vec3 free_part(const Vec3& movement) const noexcept;
  /// Returns a contact reduced to those axes. Empty if its normal is almost orthogonal to them.
  RemoteContact free_part(const RemoteContact& contact) const noexcept;

  /// Returns the present walls that limit the free axes, and behind them one wall for each body: of
  /// the last target, KeepOutBody::wall_at. Their number in `walls()` is the same from begin() on.
  std::span<const WorkspaceWall> walls() const noexcept {
    return {walls_.data(), count_ + workspace_.body_count};
  }
  const Workspace& workspace() const noexcept { return workspace_; }

 private:
  static constexpr double kHardlyFree = 0.1;  // length of a normal's part along the free axes

  std::span<const WorkspaceWall> room() const noexcept { return {walls_.data(), count_}; }
  Vec3 unlocked(const Vec3& place) const noexcept;
  void face_bodies(const Vec3& place) noexcept;
  Vec3 slide(const Vec3& from, const Vec3& wanted) const noexcept;

  Workspace workspace_;
  Pose begun_;  // the locked axes keep its values
  Pose last_;   // the last result of keep(), in front of all walls_
  // Along the free axes: count_ of the room, then one for each body.
  std::array<WorkspaceWall, Workspace::kMostWalls + Workspace::kMostBodies> walls_{};
  std::array<double, Workspace::kMostWalls> meant_{};  // [m] their final distances
  std::size_t count_ = 0;
  std::array<double, Workspace::kMostBodies> depths_{};  // [m] signed distances that are kept, <= 0
};

}  // namespace feltwire
