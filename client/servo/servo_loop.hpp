#pragma once
// The thread that closes the loop: waits for deadlines and replies, and hands them to the servo.

#include <cstdint>
#include <string_view>

#include "client/servo/event.hpp"
#include "client/servo/live_status.hpp"
#include "client/servo/prepared_change.hpp"
#include "client/servo/servo.hpp"
#include "client/servo/tick_record.hpp"
#include "client/transport/transport.hpp"
#include "core/base/ring.hpp"
#include "protocol/net/busy_poll.hpp"

namespace feltwire {

enum class EndReason : std::uint8_t {
  duration,        // the time asked for is over
  device_ended,    // the recording is over
  requested,       // stop was set
  server_goodbye,  // the server ended the session
  server_silent,   // nothing came for the session's silence timeout
  refused,  // the session was lost and another one is refused for good (never the loop's own)
  failed    // a system call that cannot fail did, or the servo thread stood still
};
std::string_view name(EndReason reason);

struct LoopOptions {
  Nanoseconds duration{0};         // 0: no limit
  Nanoseconds silence_timeout{0};  // 0: no limit
  /// How long a lost session may stay lost, and where new ones come from; null: losing it ends the
  /// loop. Meanwhile the hand goes on and commands fade.
  Nanoseconds patience{0};
  Ring<SessionAddress>* rejoined = nullptr;
  /// Changes that an admin wants, made ready: what LoopOutputs::wanted brought. They must outlive
  /// the loop. Null: none comes.
  Ring<PreparedChange*>* changes = nullptr;
  /// How long the thread looks busily for what it waits for, the reply after a sample was sent and
  /// the next deadline before it comes, instead of sleeping; kForever: it never sleeps. With 0 it
  /// only looks for the deadline when the machine has woken it sooner than it mostly does.
  Nanoseconds busy_poll{0};
};

/// A view that an observer was shown, and its time.
struct TimedView {
  double time = 0.0;  // [s] since the first tick
  SceneView view;
};

/// Rings for the output of the thread; null: not wanted. A full ring loses the newest entry, which
/// is counted.
struct LoopOutputs {
  Ring<LiveStatus>* status = nullptr;
  Ring<TickRecord>* record = nullptr;
  Ring<TimedView>* views = nullptr;      // of an observer (client/run/observed_scene.hpp)
  Ring<WantedChange>* wanted = nullptr;  // changes that an admin wants, each once
};

struct LoopResult {
  EndReason end = EndReason::failed;
  GoodbyeReason goodbye = GoodbyeReason::leaving;  // of server_goodbye
  double duration = 0.0;                           // [s] from the first tick to the last
  std::uint64_t overruns = 0;                      // ticks that came a whole period late or more
  std::uint64_t missed_deadlines = 0;              // that these passed over
  std::uint64_t records_dropped = 0;               // rows that found the ring full
  std::uint64_t views_dropped = 0;                 // views likewise
  std::uint64_t disconnections = 0;                // times the session was lost
  std::uint64_t reconnections = 0;                 // times it, or a new one, went on
  double disconnected = 0.0;                       // [s] altogether
  bool stood_still = false;  // failed: the thread did not tick, and the device was let go
  Histogram wakeup_late;     // [ns] each tick behind its deadline
};

/// Whether a loop of these never sleeps.
bool never_sleeps(Nanoseconds busy_poll, Nanoseconds period) noexcept;

/// Runs the loop in the calling thread until one of the EndReasons. It ticks when the device does,
/// where that sets the pace (Device::longest_tick). Else deadlines are absolute, start + n T: one
/// that is missed by a period or more is passed over, never made up for by a burst. Replies are
/// taken when they come (at the tick of a device that sets the pace); the command is applied at
/// the tick. At the end the force
/// fades within half the hold time, the replies on their way are waited for (at most 100 ms, and
/// 100 ms after what an emulated link holds has left it), and the server gets a goodbye. The
/// device is released as soon as the force has faded.
void run_servo_loop(Device& device, Servo& servo, Transport& transport, const LoopOptions& options,
                    const Event& stop, const LoopOutputs& outputs, LoopResult& result) noexcept;

}  // namespace feltwire
