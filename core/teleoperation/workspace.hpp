#pragma once
// Limits of a robot's target: walls, and locked axes.

#include <array>
#include <cstddef>
#include <span>

#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimate.hpp"

namespace feltwire {

/// A plane that a target stays in front of: normal . x >= distance.
struct WorkspaceWall {
  Vec3 normal = Vec3::UnitZ();  // unit, towards the side where the target may be
  double distance = 0.0;        // [m] of the plane from the origin, along the normal
  /// [m] from the wall to a point; below 0: the point is behind it.
  double clearance(const Vec3& point) const noexcept { return normal.dot(point) - distance; }
};

/// Limits of a robot's target in the robot's frame. All walls together bound a convex room. A
/// locked axis keeps the value that it had when the hand engaged.
struct Workspace {
  static constexpr std::size_t kMostGiven = 16;  // walls of a scene's seat, and of a robot
  static constexpr std::size_t kMostWalls = 2 * kMostGiven;
  static constexpr double kFarthest = 1e3;  // [m] of a wall from the origin

  std::array<WorkspaceWall, kMostWalls> walls{};
  std::size_t count = 0;
  std::array<bool, 3> locked{};  // movement along x, y, z
  bool turning_locked = false;

  std::span<const WorkspaceWall> view() const noexcept { return {walls.data(), count}; }
  bool limits() const noexcept {
    return count > 0 || locked[0] || locked[1] || locked[2] || turning_locked;
  }
  /// Precondition: there are fewer than kMostWalls, and the wall's normal is unit.
  void add(const WorkspaceWall& wall) noexcept { walls[count++] = wall; }
  /// The six walls of a box, from `low` to `high` [m] on each axis. Precondition: room for six.
  void add_box(const Vec3& low, const Vec3& high) noexcept;
};

/// Both workspaces apply. Precondition: neither has more than kMostGiven walls.
Workspace joined(const Workspace& one, const Workspace& other) noexcept;

/// Whether there is a place that is at least `inside` [m] in front of every wall. Thin wedges count
/// as no place.
bool has_room(const Workspace& workspace, double inside) noexcept;

/// Returns the nearest point to `point` that is in front of all walls, by Hildreth's row action:
/// each wall in turn moves the point to itself, or takes back its earlier movement. It is exact for
/// walls at right angles. If the sweeps do not suffice (acute wedges, no such point) the result may
/// be behind a wall, or not quite the nearest. A point in front of all walls is returned unchanged.
Vec3 nearest_in_front(const Vec3& point, std::span<const WorkspaceWall> walls) noexcept;

/// Keeps a target within a workspace, from an engagement on. If the target is behind a wall then,
/// it stays, so that the first step is zero; it may come nearer to the wall, and does not go back.
/// So for every wanted target and every time: the target is not farther behind any wall than it
/// was, and a locked axis keeps its first value.
///
/// No function allocates, throws or reads a clock.
class WorkspaceLimit {
 public:
  explicit WorkspaceLimit(const Workspace& workspace = {}) : workspace_(workspace) { begin({}); }

  /// The hand engages while the target is at `here`. Precondition: it is finite.
  void begin(const Pose& here) noexcept;
  /// Returns the nearest allowed target. A wanted target that is not finite changes nothing.
  const Pose& keep(const Pose& wanted) noexcept;

  /// Returns the part of a movement along the axes that are not locked.
  Vec3 free_part(const Vec3& movement) const noexcept;
  /// Returns a contact reduced to those axes. Empty if its normal is almost orthogonal to them.
  RemoteContact free_part(const RemoteContact& contact) const noexcept;

  /// Returns the present walls that limit the free axes. Their number in `walls()` is the same from
  /// begin() on.
  std::span<const WorkspaceWall> walls() const noexcept { return {walls_.data(), count_}; }
  const Workspace& workspace() const noexcept { return workspace_; }

 private:
  static constexpr double kHardlyFree = 0.1;  // length of a normal's part along the free axes

  Workspace workspace_;
  Pose begun_;  // the locked axes keep its values
  Pose last_;   // the last result of keep(), in front of all walls_
  std::array<WorkspaceWall, Workspace::kMostWalls> walls_{};  // along the free axes
  std::array<double, Workspace::kMostWalls> meant_{};         // [m] their final distances
  std::size_t count_ = 0;
};

}  // namespace feltwire
