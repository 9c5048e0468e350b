#pragma once
// The connection between the thread of a maker's library, which calls back at the device's tick,
// and the servo thread. A reading goes to the servo thread, and its force comes back within the
// same tick.

#include <atomic>
#include <cstdint>

#include "client/device/device.hpp"
#include "core/base/event_descriptor.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// Wakes a waiting thread. set() is safe in any thread and in a signal handler. The constructor
/// throws std::system_error if the system has no more descriptors.
class Wake {
 public:
  void set() const noexcept { signal_.signal(); }
  /// Waits until set() or `latest` (a monotonic time). An earlier set() counts.
  void wait_until(Nanoseconds latest) const noexcept;
  /// Waits until set().
  void wait() const noexcept;

 private:
  EventDescriptor signal_;
};

/// The hand-over of one device. A force is used in the tick of its own reading or never: a late
/// force is dropped, and the force of the tick before is repeated. After too many such ticks in a
/// row no force is held any more. Each reading contains the force held since the reading before:
/// the mean of the old force (until the new one arrived) and the new one.
///
/// No function allocates or locks after construction.
class SampleMailbox {
 public:
  /// `most_repeated`: the largest number of ticks in a row for which a force is repeated.
  explicit SampleMailbox(int most_repeated) : most_repeated_(most_repeated) {}

  /// For the device's thread, at its tick: offers a reading, waits for `patience` at most, and
  /// returns the force to put on the hand now.
  Command exchange(DeviceReading reading, Nanoseconds patience) noexcept;
  /// For the device's thread: the device cut the last command to this one, at once.
  void cut_to(const Command& held) noexcept { applied_ = held; }

  /// For the servo thread: waits for a reading until `latest`. False: there was none.
  bool await(Nanoseconds latest) noexcept;
  /// For the servo thread: returns the newest reading. `fresh` is false if none came since the last
  /// call.
  DeviceReading newest() noexcept;
  /// For the servo thread: gives the force for that reading. Returns the command that is held from
  /// now on.
  Command write(const Command& on_hand) noexcept;

  /// For any thread and any signal handler: no force is held from the next tick on.
  void release() noexcept { released_.store(true); }
  bool released() const noexcept { return released_.load(); }

 private:
  struct Offer {
    DeviceReading reading;
    double span = 0.0;  // [s] since the reading before
    std::uint64_t number = 0;
  };
  bool take() noexcept;

  static constexpr std::uint64_t kClosed = 1;  // there is no offer
  static constexpr std::size_t kRoom = 64;     // the number of offers that a servo thread may miss

  // Even: the number of the present offer. Odd: that offer was answered. kClosed: neither.
  std::atomic<std::uint64_t> state_{kClosed};
  std::atomic<bool> released_{false};
  Ring<Offer> offers_{kRoom};
  Command command_;  // owned by the servo thread, until the state says that the offer is answered
  Wake servo_wake_, device_wake_;

  // Only the device's thread reads and writes these members.
  int most_repeated_;
  int repeated_ = 0;
  std::uint64_t number_ = 0;
  Command before_, applied_;  // on the hand, before and after the newest answer was applied
  Nanoseconds offered_at_{0}, applied_at_{0};

  // Only the servo thread reads and writes these members.
  DeviceReading news_{.pose = {}, .fresh = false};  // not returned yet
  double news_span_ = 0.0;  // [s] the time over which its `held` is the mean
  std::uint64_t taken_ =
      0;              // the number of the newest reading; 0: it was answered, or there is none
  Command expected_;  // on the hand, as far as the servo thread knows
};

}  // namespace feltwire
