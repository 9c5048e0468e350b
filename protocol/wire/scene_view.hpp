#pragma once
// An observer's view of a scene, as values. PROTOCOL.md has their bytes.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/base/types.hpp"
#include "core/teleoperation/lead_engagement.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

/// The server's data of a hand beside its pose, for an observer that draws it. World frame. All
/// except the counts are float32 on the wire.
struct HandFigures {
  std::uint64_t samples = 0, missed = 0;  // taken so far; lost on the way so far
  Vec3 proxy = Vec3::Zero();              // [m] place of the tool if it could enter no surface
  Vec3 elastic = Vec3::Zero();            // [N] commanded by the scene
  Vec3 frictional = Vec3::Zero();         // [N] commanded by the scene
  double depth = 0.0;                     // [m] in the object in which it is deepest
  double delivered = 0.0;                 // [J] to the hand so far
  double burned = 0.0;                    // [J] lower bound of the device's burned energy so far
  std::uint32_t states = 0;               // bits of PROTOCOL.md
  std::optional<HandReport> report;       // the newest of its client; its hand_damping is not sent
  std::uint16_t tool = 0;                 // its index among the scene's tools
};

/// The tool of another session, and the force of its device. World frame, float32 on the wire.
struct SeenHand {
  std::uint32_t number = 0;   // from 1 in the order they joined the scene, never used again
  Pose pose;                  // of its newest sample
  Vec3 force = Vec3::Zero();  // [N] on the hand, held by the device as its client reports
  std::optional<HandFigures> figures{};  // all hands of a view have them, or none
};

/// The pose of a moving object. World frame, float32 on the wire.
struct SeenBody {
  std::uint16_t object = 0;  // its index in the scene, as in SurfacePatch
  Pose pose;
};

/// A robot on a seat of the scene, in its own frame. Float32 on the wire.
struct SeenRobot {
  Pose pose;                                         // of the tool
  Pose target;                                       // held by its controller
  std::optional<Vec3> force{};                       // [N] on the tool; empty: not sensed
  Vec3 torque = Vec3::Zero();                        // [N m] on the tool
  LinkState state = LinkState::disabled;             // of the robot and the hand that leads it
  std::uint32_t hand = 0;                            // the number of that hand; 0: none
  bool ok = true, stopped = false, touches = false;  // reported by the robot
  double gripper = 0.0;                              // [m] opening
  double age = 0.0;                                  // [s] since that state
  std::uint8_t seat = 0;                             // from 0, below kMostSeats
  std::uint8_t seats = 1;                            // bit i: seat i has a robot
};

/// A part of the scene: all hands with hands_from <= number < hands_end, and all moving objects
/// with bodies_from <= object < bodies_end. A hand or object of these ranges that is not listed
/// does not exist, or not any more. The next views bring the other ranges, in turns.
struct SceneView {
  static constexpr std::size_t kHandSize = 44, kBodySize = 32;   // [bytes] on the wire
  static constexpr std::size_t kFiguresSize = 88;                // [bytes] on the wire, of one hand
  static constexpr std::size_t kMaxHands = 19, kMaxBodies = 27;  // largest numbers of one view
  static constexpr std::size_t kMaxFigures = 6;  // largest number of hands with figures
  static constexpr std::uint32_t kLastHand = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint16_t kLastBody = std::numeric_limits<std::uint16_t>::max();

  bool present = false;  // false: the reply had no view, and the values below are not valid
  std::uint32_t hands_from = 0, hands_end = 0;
  std::uint16_t bodies_from = 0, bodies_end = 0;
  std::size_t hand_count = 0, body_count = 0;
  std::optional<SeenRobot> robot;         // in every view while there are robots, of each in turn
  std::array<SeenHand, kMaxHands> hand;   // by rising number
  std::array<SeenBody, kMaxBodies> body;  // by rising object

  std::span<const SeenHand> hands() const { return {hand.data(), hand_count}; }
  std::span<const SeenBody> bodies() const { return {body.data(), body_count}; }
};

/// [bytes] The room for the hands and bodies of a view together, so that every reply fits a
/// datagram. If the client sends datagrams so rarely [s] that its line must be a thin one, there is
/// less room, so that a reply is no longer than one with a model.
constexpr std::size_t view_room(double between_datagrams) {
  constexpr std::size_t kRoom = 864, kThinRoom = 264;
  constexpr double kThin = 0.04;  // [s]
  return between_datagrams > kThin ? kThinRoom : kRoom;
}
/// [bytes] The part for a robot.
inline constexpr std::size_t kSeenRobotRoom = 112;
/// [bytes] The part for figures, in addition to their own size.
inline constexpr std::size_t kFiguresOverhead = 32;

}  // namespace feltwire
