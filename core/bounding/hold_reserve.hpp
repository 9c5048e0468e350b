#pragma once
// The assumed hold time of a force, from the measured lateness of the ticks.

namespace feltwire {

/// The time for which the force of this tick is assumed to be held. The next tick may be late, so
/// it is T plus twice the largest lateness of the last second or two, at most 2 T. A tick that is a
/// whole period late is an overrun, whose debt the port repays.
class HoldReserve {
 public:
  /// T [s].
  explicit HoldReserve(double period) : period_(period) {}

  /// Takes the duration for which the last force was held [s].
  void saw(double hold_time) noexcept;
  double hold_time() const noexcept;  // [s]

 private:
  static constexpr double kWindow = 1.0;  // [s] a maximum is forgotten after one or two windows
  double period_;
  double over_ = 0.0,
         over_before_ = 0.0;  // [s] largest excess over T, in this window and in the last
  double window_ = 0.0;       // [s] age of this window
};

}  // namespace feltwire
