#pragma once
// The walls of a robot's workspace, as the hand that leads the robot feels them.

#include <array>
#include <cstdint>
#include <span>

#include "core/base/types.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/robot.hpp"
#include "core/teleoperation/surface_offset.hpp"

namespace feltwire {

/// Springs that begin in front of the walls. A hand that moves on behind a wall takes its offset
/// along: the length of the spring stays, and the robot follows at once when the hand comes back.
/// If the hand is already in a spring when it first receives the wall (it engages there), the
/// spring has no force, and gets force as the hand pushes on. So a wall gives the hand no more
/// energy than the hand has pressed into it. No function allocates, throws or reads a clock.
class RobotWalls {
 public:
  /// `fade` [s] > 0: the force of removed walls falls to zero in this time.
  explicit RobotWalls(double fade) : fade_(fade) {}

  void clear() noexcept;
  /// Whether a hand is in the spring of one of these walls while the wanted place of its robot is
  /// `wanted`.
  static bool reach(const Vec3& wanted, std::span<const RemoteWall> walls) noexcept;
  /// The hand is at `hand`, and these are the present walls. Empty: the robot does not follow.
  void step(const Vec3& hand, std::span<const RemoteWall> walls, SurfaceOffset& index,
            double elapsed) noexcept;
  /// The force on the hand [N].
  Vec3 push(const Tool& tool, double elapsed) noexcept;
  /// Whether push() may be other than zero.
  bool pushes() const noexcept { return weight_ > 0.0; }
  /// The surfaces of the walls, for RiseLimit.
  const LocalModel& model() const noexcept { return springs_.model(); }

 private:
  /// A spring that contained the hand before it pushed.
  struct Slack {
    std::uint32_t number = 0;
    double way = 0.0;  // [m] part of the spring without force
  };
  double slack_of(const RemoteWall& wall, double pressed) const noexcept;

  double fade_;
  double weight_ = 0.0;  // weight of the force, 0 to 1
  LocalContact springs_;
  std::array<Slack, kMostRemoteWalls> slacks_{};
  std::size_t count_ = 0;
};

}  // namespace feltwire
