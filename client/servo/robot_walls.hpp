#pragma once
// What a hand that leads a robot feels of the walls of the robot's workspace.

#include <array>
#include <cstdint>
#include <span>

#include "core/base/types.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/surface_index.hpp"
#include "protocol/wire/robot.hpp"

namespace feltwire {

/// Springs that begin in front of the walls. A hand that goes on behind a wall takes its offset
/// along: the spring stays as long as it is, and the robot follows at once where the hand comes
/// back. Where the hand is in a spring already when it first hears of the wall (it engages there),
/// the spring has no force, and gets some as the hand pushes on. So a wall gives the hand no more
/// than the hand has pressed into it. Nothing here allocates, throws or reads a clock.
class RobotWalls {
 public:
  /// `fade` [s] > 0: the force of walls that are no more falls to nothing in this time.
  explicit RobotWalls(double fade) : fade_(fade) {}

  void clear() noexcept;
  /// Whether a hand whose robot is wanted at `wanted` is in the spring of one of these walls.
  static bool reach(const Vec3& wanted, std::span<const RemoteWall> walls) noexcept;
  /// The hand is at `hand`, and these walls are told; none: the robot does not follow.
  void step(const Vec3& hand, std::span<const RemoteWall> walls, SurfaceIndex& index,
            double elapsed) noexcept;
  /// [N] on the hand.
  Vec3 push(const Tool& tool, double elapsed) noexcept;
  /// Their surfaces, for who asks how fast the force may rise.
  const LocalModel& model() const noexcept { return springs_.model(); }

 private:
  /// A spring that the hand was in before it pushed.
  struct Slack {
    std::uint32_t number = 0;
    double way = 0.0;  // [m] of the spring, without force
  };
  double slack_of(const RemoteWall& wall, double pressed) const noexcept;

  double fade_;
  double weight_ = 0.0;  // of the force, 0 to 1
  LocalContact springs_;
  std::array<Slack, kMostRemoteWalls> slacks_{};
  std::size_t count_ = 0;
};

}  // namespace feltwire
