#pragma once
// Live changes of a scene and its sessions, on request.

#include <cstdint>

#include "protocol/session/live_change.hpp"
#include "protocol/wire/control.hpp"
#include "server/scene/apply_live_change.hpp"
#include "server/scene/robot_seats.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/served_scene.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/session_table.hpp"
#include "server/scene/world_clock.hpp"

namespace feltwire {

/// Every change goes into the log. A refused one changes nothing.
class AdminChanges {
 public:
  /// The other stages must outlive this.
  AdminChanges(ServedScene& served, WorldClock& clock, SessionTable& table, const RobotSeats& seats,
               SceneLog& log)
      : served_(served), clock_(clock), table_(table), seats_(seats), log_(log) {}

  /// Makes a change from the next sample on, or refuses it. The scene in the result must outlive
  /// the sessions. Allocates; throws std::bad_alloc and changes nothing if there is no memory for
  /// it.
  ChangeOutcome change(const LiveChange& change, Nanoseconds now);
  /// SurfacesTaken, or Refused: the session's client has these objects in full. Allocates.
  control::Message take_surfaces(const control::TakeSurfaces& request, Nanoseconds now);

 private:
  ChangeOutcome make(const MaterialChange& change, Nanoseconds now);
  ChangeOutcome make(const GravityChange& change, Nanoseconds now);
  ChangeOutcome make(const ParameterChange& change, Nanoseconds now);
  ChangeOutcome make(const LinkChange& change, Nanoseconds now);
  ChangeOutcome make(const LeadChange& change, Nanoseconds now);
  void log(EventKind kind, Nanoseconds now, Bytes payload, std::uint32_t hand = 0) noexcept {
    log_.put({.kind = kind, .hand = hand, .time = now, .payload = payload});
  }

  ServedScene& served_;
  WorldClock& clock_;
  SessionTable& table_;
  const RobotSeats& seats_;
  SceneLog& log_;
};

}  // namespace feltwire
