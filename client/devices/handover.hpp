#pragma once
// Between the thread of a maker's library that calls us back at the device's tick, and the servo
// thread: a reading goes one way, the force made of it the other, within the tick.

#include <atomic>
#include <cstdint>

#include "client/devices/device.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// Wakes a thread that waits. set() is safe in any thread and in a signal handler.
class Wake {
 public:
  /// Throws std::system_error when the system has no more descriptors.
  Wake();
  ~Wake();
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;
  void set() const noexcept;
  /// Until set() or `latest` (a monotonic time). A set() from before counts.
  void wait_until(Nanoseconds latest) const noexcept;
  /// Until set().
  void wait() const noexcept;

 private:
  int descriptor_;
};

/// The hand-over of one device. A force is used in the tick of the reading that it was made of, or
/// not at all: one that comes too late is dropped, and the tick before's is repeated. After too
/// many such ticks in a row nothing is held any more. Each reading says what was held since the one
/// before, the mean of the old force (until the new one was there) and the new.
///
/// Nothing here allocates or locks after construction.
class Handover {
 public:
  /// `most_repeated`: ticks in a row for which a force is repeated at most.
  explicit Handover(int most_repeated) : most_repeated_(most_repeated) {}

  /// By the device's thread, at its tick: offers a reading, waits for `patience` at most, and
  /// returns what to put on the hand now.
  Command exchange(DeviceReading reading, Nanoseconds patience) noexcept;
  /// By the device's thread: the device cut the last command to this, at once.
  void cut_to(const Command& held) noexcept { applied_ = held; }

  /// By the servo thread: waits for a reading until `latest`; false: none came.
  bool await(Nanoseconds latest) noexcept;
  /// By the servo thread: the newest reading; `fresh` is false where none came since the last call.
  DeviceReading newest() noexcept;
  /// By the servo thread: gives the force for that reading. Returns what is held from now on.
  Command write(const Command& on_hand) noexcept;

  /// Any thread, any signal handler: from the next tick on nothing is held.
  void release() noexcept { released_.store(true); }
  bool released() const noexcept { return released_.load(); }

 private:
  struct Offer {
    DeviceReading reading;
    double span = 0.0;  // [s] since the one before
    std::uint64_t number = 0;
  };
  bool take() noexcept;

  static constexpr std::uint64_t kClosed = 1;  // no offer stands
  static constexpr std::size_t kRoom = 64;     // offers that a servo thread may sleep through

  // Even: the offer of that number stands. One more: it was answered. kClosed: neither.
  std::atomic<std::uint64_t> state_{kClosed};
  std::atomic<bool> released_{false};
  Ring<Offer> offers_{kRoom};
  Command command_;  // the servo thread's, until the state says that the offer is answered
  Wake servo_wake_, device_wake_;

  // Only the device's thread reads and writes these.
  int most_repeated_;
  int repeated_ = 0;
  std::uint64_t number_ = 0;
  Command before_, applied_;  // on the hand before and after the newest answer was taken up
  Nanoseconds offered_at_{0}, applied_at_{0};

  // Only the servo thread reads and writes these.
  DeviceReading news_{.pose = {}, .fresh = false};  // not given out yet
  double news_span_ = 0.0;                          // [s] the time that its `held` is the mean of
  std::uint64_t taken_ = 0;  // the number of the newest reading; 0: answered, or none
  Command expected_;         // on the hand, as far as is known here
};

}  // namespace feltwire
