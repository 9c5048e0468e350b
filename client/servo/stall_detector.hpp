#pragma once
// Detects, from looks at the signs of life of a servo thread, that it stands still.

#include <cstdint>
#include <optional>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Servo periods after the beginning of a tick in which the next one must begin while a force is
/// held. A thread without real-time scheduling gets more: on a machine with other work its ticks
/// are late by some periods now and then.
inline constexpr double kLateTicks = 5.0, kLateTicksWithoutRealTime = 20.0;
inline constexpr double kLeastLateTicks = 2.0;

/// [s] For which a force may be held without a tick. `asked` [s]: what the user chose; 0: the usual
/// time. It is at most the hold time, and at least kLeastLateTicks servo periods.
double let_go_time(double servo_period, double hold_time, double asked, bool real_time) noexcept;

/// Counts the time in which a servo thread shows no sign of life. If the watch itself was not run
/// for so long that the servo thread was not either (the program was stopped as a whole), then that
/// time counts once as none, and the servo thread has time to tick again.
class StallDetector {
 public:
  static constexpr Nanoseconds kIdle =
      std::chrono::seconds(2);  // the same time if there is no force
  static constexpr Nanoseconds kGrace = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t {
    ticks,
    stands_still,  // from now on, every time: release the device
    gone           // also for kGrace after that: do not wait for it any more
  };

  /// The signs of life of the thread.
  struct SignsOfLife {
    std::uint64_t calls = 0;  // of the device that have returned
    Nanoseconds tick{0};      // the time at which the newest tick began
    bool pulls = false;       // a force is on the hand
    bool awaits = false;      // it waits for the tick of a device that sets the pace
  };

  /// A force is held for at most `late` after the beginning of the newest tick, and for at most
  /// `hold` if the next tick is the device's.
  StallDetector(Nanoseconds late, Nanoseconds hold)
      : late_(late), hold_(hold < late ? late : hold), limit_(late) {}

  /// The time from a look to the next one.
  Nanoseconds pause() const noexcept;
  /// `now`: a monotonic time.
  Verdict look(Nanoseconds now, const SignsOfLife& life) noexcept;
  /// The time without a sign of life, at the last look before the thread stood still for good.
  Nanoseconds still() const noexcept { return still_; }

 private:
  Nanoseconds late_, hold_;
  Nanoseconds limit_;                  // of pulling_
  std::optional<Nanoseconds> looked_;  // the time of the last look
  std::uint64_t calls_ = 0;
  Nanoseconds still_{0}, pulling_{0}, since_{0};
  bool forgiven_ = false;  // a time in which the watch was not run, since the last sign of life
  bool stands_still_ = false;
};

}  // namespace feltwire
