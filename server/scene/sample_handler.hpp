#pragma once
// Answers the payload of an admitted datagram: the samples of a hand, or the state of a robot.

#include "protocol/wire/codec.hpp"
#include "protocol/wire/datagram.hpp"
#include "server/scene/client_changes.hpp"
#include "server/scene/datagram_gate.hpp"
#include "server/scene/observer_views.hpp"
#include "server/scene/path_limits.hpp"
#include "server/scene/robot_seats.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

/// Neither function allocates.
class SampleHandler {
 public:
  /// The other stages must outlive this.
  SampleHandler(DatagramGate& gate, RobotSeats& seats, ClientChanges& client_changes,
                PathLimits& paths, ObserverViews& views, SceneLog& log)
      : gate_(gate),
        seats_(seats),
        client_changes_(client_changes),
        paths_(paths),
        views_(views),
        log_(log) {}

  /// Takes samples. Returns the payload of the reply, valid until the next call; empty: the samples
  /// were dropped, or the client needs no reply.
  Bytes answer(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept;
  /// Takes the state of a robot. RobotSeats::forward() answers it.
  void take_state(SessionSlot& robot, Bytes payload, const Origin& origin) noexcept;

 private:
  Bytes reply_to_hand(SessionSlot& slot, Reply& reply, Nanoseconds now) noexcept;
  Bytes reply_to_observer(SessionSlot& slot, const Reply& reply, Nanoseconds now) noexcept;

  DatagramGate& gate_;
  RobotSeats& seats_;
  ClientChanges& client_changes_;
  PathLimits& paths_;
  ObserverViews& views_;
  SceneLog& log_;
  SampleBatch batch_;  // the present samples
  RobotState state_;   // the present state
  Encoder encoder_;
};

}  // namespace feltwire
