#pragma once
// How the force comes and goes as a whole: by the age of its command, and when it must end.

#include <algorithm>

#include "core/base/time.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// A command holds in full until it is half the hold time old, and falls linearly to zero at the
/// hold time. A force that must end falls to zero within half the hold time. A faded force comes
/// back no faster.
class ForceFade {
 public:
  /// The force falls from now on. Nothing changes if it falls already.
  void begin(Nanoseconds now) noexcept {
    if (ending_) return;
    ending_ = true;
    from_ = now;
  }
  /// It is at zero: the next command counts again.
  void end() noexcept { ending_ = false; }
  bool ending() const noexcept { return ending_; }
  void move_times(Nanoseconds by) noexcept { from_ += by; }

  /// Returns the share of the command for the tick at `now`, 0 to 1. `age` [s] of the command,
  /// `elapsed` [s] since the tick before.
  double step(Nanoseconds now, double age, double elapsed, double hold_time) noexcept;
  /// The share of the last step().
  double share() const noexcept { return share_; }
  /// At the last step() the command was too old for any force, and nothing else ended the force.
  bool silent() const noexcept { return silent_; }

 private:
  bool ending_ = false, silent_ = false;
  Nanoseconds from_{0};
  double share_ = 1.0;
};

/// The command times `share`, but at most the device's force and torque times it: a far larger
/// command would vanish in a single step of a fade.
Command faded(const Command& command, double share, double most_force, double most_torque) noexcept;

}  // namespace feltwire
