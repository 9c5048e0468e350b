#pragma once
// The thread that closes the loop: it waits for deadlines and replies, and gives them to the servo.

#include <cstdint>
#include <string_view>

#include "client/device/guarded_device.hpp"
#include "client/servo/event.hpp"
#include "client/servo/live_status.hpp"
#include "client/servo/prepared_change.hpp"
#include "client/servo/servo.hpp"
#include "client/servo/tick_record.hpp"
#include "client/servo/timed_device.hpp"
#include "client/transport/transport.hpp"
#include "core/base/ring.hpp"
#include "protocol/net/busy_poll.hpp"

namespace feltwire {

enum class EndReason : std::uint8_t {
  duration,        // the requested time is over
  device_ended,    // the recording is over
  requested,       // stop was set
  server_goodbye,  // the server ended the session
  server_silent,   // no datagram came for the session's silence timeout
  refused,  // the session was lost and another one is refused for good (never the loop's own)
  failed    // a system call failed that cannot fail, or the servo thread stood still
};
std::string_view name(EndReason reason);

struct LoopOptions {
  Nanoseconds duration{0};         // 0: no limit
  Nanoseconds silence_timeout{0};  // 0: no limit
  /// The time for which a session may stay lost, and the source of new ones; null: the loop ends
  /// with the session. Meanwhile the hand moves on and commands fade.
  Nanoseconds patience{0};
  Ring<SessionAddress>* rejoined = nullptr;
  /// Prepared changes of an admin, from LoopOutputs::wanted. They must outlive the loop. Null:
  /// there are none.
  Ring<PreparedChange*>* changes = nullptr;
  /// Scenes that SceneFetch has fetched for the local model; null: it fetches none.
  Ring<const FetchedScene*>* fetched = nullptr;
  /// The time for which the thread polls, instead of sleeping: for the reply after a sample was
  /// sent, and for the next deadline before it comes; kForever: it never sleeps. With 0 it polls
  /// only for the deadline, if the machine has woken it sooner than usual.
  Nanoseconds busy_poll{0};
};

/// A view that an observer got, and its time.
struct TimedView {
  double time = 0.0;  // [s] since the first tick
  SceneView view;
};

/// Gets every tick. The servo thread calls it: it must not wait, allocate or throw.
class TickListener {
 public:
  virtual ~TickListener() = default;
  /// `connected`: the session is not lost.
  virtual void ticked(const TickRecord& tick, bool connected) noexcept = 0;
};

/// Rings for the output of the thread; null: no output. A full ring loses the newest entry and
/// counts it.
struct LoopOutputs {
  Ring<LiveStatus>* status = nullptr;
  Ring<TickRecord>* record = nullptr;
  Ring<TimedView>* views = nullptr;      // for an observer (client/run/observed_scene.hpp)
  Ring<WantedChange>* wanted = nullptr;  // changes that an admin wants, each once
  TickListener* listener = nullptr;
};

struct LoopResult {
  EndReason end = EndReason::failed;
  GoodbyeReason goodbye = GoodbyeReason::leaving;  // if the end is server_goodbye
  double duration = 0.0;                           // [s] from the first tick to the last
  std::uint64_t overruns = 0;                      // ticks that came a whole period late or more
  std::uint64_t missed_deadlines = 0;              // deadlines that these passed over
  std::uint64_t records_dropped = 0;               // rows for which the ring was full
  std::uint64_t views_dropped = 0;                 // views for which the ring was full
  std::uint64_t disconnections = 0;                // times the session was lost
  std::uint64_t reconnections = 0;                 // times that it, or a new one, continued
  double disconnected = 0.0;                       // [s] in total
  double lost_for = 0.0;  // [s] since the session was lost, if there was none at the end
  EndReason lost_by = EndReason::server_silent;  // why, if lost_for > 0 (or server_goodbye)
  bool stood_still = false;   // failed: the thread did not tick, and the device was released
  double let_go_after = 0.0;  // [s] without a tick, while a force is held, the watch lets go
  double still_for = 0.0;     // [s] without a sign of life, if it stood still
  DeviceCall still_in = DeviceCall::none;  // the call of the device that did not return
  Histogram wakeup_late;                   // [ns] of each tick behind its deadline
  DeviceTimes device;
  bool paced = false;  // the device sets the pace
};

/// Whether a loop with these options never sleeps.
bool never_sleeps(Nanoseconds busy_poll, Nanoseconds period) noexcept;

/// Runs the loop in the calling thread until one of the EndReasons. If the device sets the pace
/// (Device::longest_tick), the loop ticks with the device. Otherwise deadlines are absolute, start
/// + n T: a deadline missed by a period or more is passed over, and no burst makes up for it.
/// Replies are taken when they come (at the tick of a device that sets the pace); the command is
/// applied at the tick. At the end the force fades within half the hold time. The loop then waits
/// for the replies on their way (at most 100 ms, and 100 ms after the last datagram has left an
/// emulated link), and sends the server a goodbye. The device is released as soon as the force has
/// faded.
void run_servo_loop(Device& device, Servo& servo, Transport& transport, const LoopOptions& options,
                    const Event& stop, const LoopOutputs& outputs, LoopResult& result) noexcept;

}  // namespace feltwire
