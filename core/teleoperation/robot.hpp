#pragma once
// The messages between a hand that leads and a robot that follows, as values. PROTOCOL.md, "A robot
// that follows", has their bytes.

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/time.hpp"
#include "core/base/types.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/lead_engagement.hpp"
#include "core/teleoperation/remote_contact.hpp"
#include "core/teleoperation/workspace.hpp"

namespace feltwire {

/// The part of a sample that a hand adds when it leads a robot.
struct Lead {
  bool deadman = false;  // the person holds the switch that lets the hand move the robot
  /// The greatest number of the robot's surfaces that the hand renders; 0: none.
  std::uint32_t known_surface = 0;
  Vec3 offset =
      Vec3::Zero();        // [m] the robot's wanted place is the hand's place less this; float32
  double hand_work = 0.0;  // [J] total that the hand paid into the robot's contacts
  double gripper = -1.0;   // [m] wanted opening; < 0: no wish; float32
  std::uint8_t seat = 0;   // of the robot that the hand wants to lead, as numbered when it joined
};

/// A wall of the robot's workspace for a leading hand: in the hand's frame, before its offset. The
/// target ends at the wall; the hand feels a spring that begins `depth` in front of it.
struct RemoteWall {
  WorkspaceWall wall;      // its normal is float32 on the wire
  double stiffness = 0.0;  // [N/m] > 0; float32
  double depth = 0.0;      // [m] > 0; float32
  std::uint32_t number = 0;
};
inline constexpr int kMostRemoteWalls = 3;

/// The part of a reply with the robot's state for a leading hand. The contact's stiffness is that
/// of surface and robot in series. Its vectors, except the point, are float32 on the wire.
struct Remote {
  LinkState state = LinkState::disabled;
  std::uint8_t seat = 0;  // the robot's
  /// False: another hand leads with this one. That hand's offset takes up a first touch for both.
  bool meets_surfaces = true;
  Pose pose;                                         // of the robot's tool, in its own frame
  RemoteContact contact;                             // at the hand, before its offset
  OtherSurfaces others = {};                         // the same
  EnergyCounters energy;                             // in the hand's units
  double gripper = 0.0, gripper_force = 0.0;         // [m] opening, [N] holding force
  double age = 0.0;                                  // [s] since that came from the robot
  std::array<RemoteWall, kMostRemoteWalls> walls{};  // those nearest to the target
  int wall_count = 0;
  /// [rad] Rotation vector by which the hand has to turn until it is aligned with the robot
  /// (Alignment::missing). None: it is engaged, or need not be aligned.
  std::optional<Vec3> turn{};
};

/// A servo sample of a robot, in its own frame.
struct RobotState {
  std::uint64_t index = 0;               // counted by the follower from 1
  Nanoseconds time{0};                   // the follower's monotonic clock
  Pose pose, commanded;                  // of the tool; the target that its controller holds
  Vec3 velocity = Vec3::Zero();          // [m/s]
  Vec3 angular_velocity = Vec3::Zero();  // [rad/s]
  std::optional<Vec3> force;             // [N] of the environment on the tool; none: not sensed
  Vec3 torque = Vec3::Zero();            // [N m]
  RemoteContact contact;                 // as in Remote, in the robot's frame
  OtherSurfaces others = {};             // the same
  EnergyCounters energy;
  double gripper = 0.0, gripper_force = 0.0;  // [m], [N]
  bool ok = true;                             // false: it has a fault and holds by itself
  bool stopped = false;                       // a protective stop
};

/// The wanted place of the tool.
struct RobotTarget {
  std::uint64_t index = 0;         // counts the targets; one that is not newer changes nothing
  std::uint64_t sample_index = 0;  // the leader's sample from which it comes; 0: none
  LinkState state = LinkState::disabled;  // the robot follows it if this is `engaged`
  Pose pose;
  double gripper = -1.0;            // [m] opening; < 0: it stays
  std::uint32_t known_surface = 0;  // known to the hand
  double hand_work = 0.0;           // [J] total, in the robot's units
};

}  // namespace feltwire
