#pragma once
// Decides which values need not be sent (Weber's fraction on vectors), and the receiver's
// assumption meanwhile (Hinterseer, Steinbach, Hirche, Buss, ICASSP 2005; Hinterseer et al., IEEE
// Trans. Signal Processing 56(2), 2008). It has no clock and no state except the trend's, and gives
// the same bits on both sides.

#include <array>

#include "core/base/types.hpp"

namespace feltwire {

/// No hand feels a change below these, for every fraction: a fifth of the force that a resting
/// hand notices, and the torque of that force at an arm of 40 mm.
inline constexpr double kUnfeltForce = 0.01;   // [N]
inline constexpr double kUnfeltTorque = 4e-4;  // [N m]

/// Whether `value` lies farther from `expected` than `fraction` of its own length plus `floor`. It
/// is compared with the value itself, not with the one sent last, so that the receiver's error is
/// at most that fraction of the truth. True for a value that is not finite.
bool beyond_deadband(const Vec3& value, const Vec3& expected, double fraction,
                     double floor) noexcept;

/// Checks a command: its whole force, or its torque. True also if only one of the two
/// commands is zero: contact begins or ends.
bool beyond_deadband(const Command& value, const Command& expected, double fraction) noexcept;

/// Whether there is any force or torque.
bool acts(const Command& command) noexcept;

/// The command `time` [s] later if it changes by `rates` [N/s], [N m/s]. Each part goes no farther
/// than to the point where it would begin to point backwards: a line that falls through zero must
/// not turn a push into a pull. A time that is not above zero, and rates that are not finite, leave
/// the command unchanged.
Command extrapolated(const Command& command, const Command& rates, double time) noexcept;

/// The rate of change of a command: the difference over a window of samples. One sample's
/// difference would contain the encoder's quantum, K quantum / T; the window divides that by its
/// length, with a lag of half of it. Samples before contact began or ended do not belong to the
/// line.
class CommandTrend {
 public:
  /// `elapsed` [s] since the command before.
  void add(const Command& command, double elapsed) noexcept;
  /// [N/s], [N m/s]; zero while there are too few samples.
  Command rates() const noexcept;
  void restart() noexcept { count_ = 0; }

 private:
  static constexpr double kWindow = 0.01;           // [s] a hand changes little within it
  static constexpr double kLeast = 0.25 * kWindow;  // [s] a shorter one gives no rate
  static constexpr std::size_t kEntries = 16;
  static constexpr double kSpacing = kWindow / (kEntries - 2);  // [s] of entries, at high rates

  struct Entry {
    double time = 0.0;  // [s]
    Command command;
  };
  const Entry& back(std::size_t steps) const {
    return entries_[(newest_ + kEntries - steps) % kEntries];
  }

  std::array<Entry, kEntries> entries_{};
  std::size_t newest_ = 0, count_ = 0;
  double time_ = 0.0;
};

}  // namespace feltwire
