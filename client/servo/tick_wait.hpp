#pragma once
// The servo loop's wait for its next tick, for replies and for the stop event.

#include <poll.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/device/device.hpp"
#include "client/servo/deadlines.hpp"
#include "client/servo/event.hpp"
#include "client/transport/transport.hpp"
#include "protocol/wire/hand_times.hpp"

namespace feltwire {

/// Waits for deadlines, or for a device that sets the tick rate, and counts the ticks that come
/// late. For the servo thread; nothing here allocates or throws.
class TickWait {
 public:
  /// `busy_poll`: LoopOptions::busy_poll. `port` and `stop` must outlive this.
  TickWait(DatagramPort& port, const Event& stop, Nanoseconds start, Nanoseconds period,
           Nanoseconds busy_poll, bool paced) noexcept;

  /// Moments on which a wait depends.
  struct Moments {
    Nanoseconds last_tick{0};
    double hold_time = 0.0;      // [s] of the session
    bool reply_awaited = false;  // for the newest sample
  };
  /// Events that may end a wait besides a tick.
  enum class For { replies_and_stop, replies };

  /// Waits until the port or the stop event is ready, a tick is due, or a datagram of the emulated
  /// link is due. Sleeps if neither a reply nor a deadline is near. Uses no other timer, because
  /// its interrupt would delay the tick. Returns as poll().
  int wait(Device& device, const Moments& moments, For what = For::replies_and_stop) noexcept;
  /// Waits for a datagram until `latest`. Returns as poll().
  int wait_for_reply(Nanoseconds latest) noexcept;
  /// Whether the last wait() found a datagram.
  bool reply_is_there() const noexcept { return waiting_[0].revents != 0; }

  struct Due {
    bool due = false;
    std::uint64_t missed = 0;              // deadlines that were passed over
    std::optional<Nanoseconds> late = {};  // behind the deadline; none for a device's first tick
  };
  /// Whether a deadline has passed, or the device's tick came or is overdue. Each due tick counts
  /// once. `ticked`: there was a tick before.
  Due due(Nanoseconds now, Nanoseconds last_tick, bool ticked) noexcept;

  bool paced() const noexcept { return paced_; }  // by the device
  /// A paced device did not tick in time.
  bool device_missed() const noexcept { return paced_ && !device_ticked_; }
  /// The lateness of all ticks.
  const HandTimes::Counts& wakeups() const noexcept { return wakeups_; }

 private:
  int await_device(Device& device, const Moments& moments, std::size_t count) noexcept;
  bool looks_busily(Nanoseconds now, const Moments& moments) const noexcept;
  Due device_due(Nanoseconds now, Nanoseconds last_tick, bool ticked) noexcept;

  DatagramPort& port_;
  Nanoseconds period_, busy_poll_;
  bool paced_;  // whether the device sets the tick rate; else the deadlines do
  Deadlines deadlines_;
  bool device_ticked_ = false;
  Nanoseconds overdue_at_{0};
  std::array<pollfd, 2> waiting_;  // descriptors for replies and for the stop event
  HandTimes::Counts wakeups_{};
};

}  // namespace feltwire
