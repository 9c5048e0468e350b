#pragma once
// The view of a scene that an observer is shown, as values. PROTOCOL.md has their bytes.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/base/types.hpp"
#include "core/teleoperation/authority.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

/// What the server knows of a hand beside its pose, for an observer that draws it. World frame. All
/// but the counts are float32 on the wire.
struct HandFigures {
  std::uint64_t samples = 0, missed = 0;  // taken so far; lost on the way so far
  Vec3 proxy = Vec3::Zero();         // [m] where the tool would be if no surface could be entered
  Vec3 elastic = Vec3::Zero();       // [N] that the scene asks for
  Vec3 frictional = Vec3::Zero();    // [N] likewise
  double depth = 0.0;                // [m] in the object that it is deepest in
  double delivered = 0.0;            // [J] to the hand so far
  double burned = 0.0;               // [J] by the device so far, at least
  std::uint32_t states = 0;          // bits, as PROTOCOL.md has them
  std::optional<HandReport> report;  // the newest of its client; its hand_damping is not told
  std::uint16_t tool = 0;            // its place among the scene's tools
};

/// The tool of another session, and the force of its device. World frame, float32 on the wire.
struct SeenHand {
  std::uint32_t number = 0;   // from 1 in the order they joined the scene, never used again
  Pose pose;                  // of its newest sample
  Vec3 force = Vec3::Zero();  // [N] on the hand, as its client says that the device holds it
  std::optional<HandFigures> figures{};  // all hands of a view have them, or none
};

/// The pose of a moving object. World frame, float32 on the wire.
struct SeenBody {
  std::uint16_t object = 0;  // its place among the scene's objects, as in SurfacePatch
  Pose pose;
};

/// The robot on the scene's seat, in its own frame. Float32 on the wire.
struct SeenRobot {
  Pose pose;                                         // of the tool
  Pose target;                                       // that its controller holds
  std::optional<Vec3> force{};                       // [N] on the tool; none: not sensed
  Vec3 torque = Vec3::Zero();                        // [N m] likewise
  LinkState state = LinkState::disabled;             // of it and the hand that leads it
  std::uint32_t hand = 0;                            // the number of that hand; 0: none
  bool ok = true, stopped = false, touches = false;  // as it says
  double gripper = 0.0;                              // [m] opening
  double age = 0.0;                                  // [s] since it said all that
};

/// A part of the scene: all hands with hands_from <= number < hands_end, and all moving objects
/// with bodies_from <= object < bodies_end. A hand or object of these ranges that is not listed
/// does not exist, or not any more. The next views bring the other ranges, in turns.
struct SceneView {
  static constexpr std::size_t kHandSize = 44, kBodySize = 32;   // [bytes] on the wire
  static constexpr std::size_t kFiguresSize = 88;                // likewise, of one hand
  static constexpr std::size_t kMaxHands = 19, kMaxBodies = 27;  // of one
  static constexpr std::size_t kMaxFigures = 6;                  // and so hands that have them
  static constexpr std::uint32_t kLastHand = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint16_t kLastBody = std::numeric_limits<std::uint16_t>::max();

  bool present = false;  // else the reply had no view, and the values below mean nothing
  std::uint32_t hands_from = 0, hands_end = 0;
  std::uint16_t bodies_from = 0, bodies_end = 0;
  std::size_t hand_count = 0, body_count = 0;
  std::optional<SeenRobot> robot;         // in every view while a robot sits there
  std::array<SeenHand, kMaxHands> hand;   // by rising number
  std::array<SeenBody, kMaxBodies> body;  // by rising object

  std::span<const SeenHand> hands() const { return {hand.data(), hand_count}; }
  std::span<const SeenBody> bodies() const { return {body.data(), body_count}; }
};

/// [bytes] The room for the hands and bodies of a view together, so that every reply fits a
/// datagram. Where the client sends datagrams so rarely [s] that its line must be a thin one, there
/// is less room, so that a reply is no longer than one with a model.
constexpr std::size_t view_room(double between_datagrams) {
  constexpr std::size_t kRoom = 864, kThinRoom = 264;
  constexpr double kThin = 0.04;  // [s]
  return between_datagrams > kThin ? kThinRoom : kRoom;
}
/// [bytes] That a robot takes of it.
inline constexpr std::size_t kSeenRobotRoom = 112;
/// [bytes] That figures take of it beside their own size.
inline constexpr std::size_t kFiguresOverhead = 32;

}  // namespace feltwire
