#pragma once
// The assumed hold time of a force, from the measured lateness of the ticks.

namespace feltwire {

/// The time for which the force of this tick is assumed to be held. The next tick may be as late as
/// the latest of the last second or two. The excess over T counts up to T: a tick that is a whole
/// period late is an overrun, whose debt nothing can pay in advance.
///
/// The assumed time follows the ticks little by little. Else a force that
/// the account pays to its limit would fall at once, and a hand that stands still would feel each
/// late tick (docs/bounding.md, "After a tick that is late").
class HoldTimeMargin {
 public:
  /// T [s].
  explicit HoldTimeMargin(double period) : period_(period) {}

  /// Takes the duration for which the last force was held [s]. `felt`: a hand that stood still felt
  /// it, so that the need of any hand must not jump.
  void saw(double hold_time, bool felt) noexcept;
  /// [s] T and the excess, for a need that grows with the square of the hold time.
  double hold_time() const noexcept { return period_ + reserved_; }
  /// [s] T and twice the excess, at most 2 T, for the need of a hand that may do anything: it grows
  /// with the hold time, not with its square.
  double hold_time_of_any_hand() const noexcept { return period_ + reserved_of_any_hand_; }

 private:
  static constexpr double kWindow = 1.0;  // [s] a maximum is forgotten after one or two windows
  double period_;
  double over_ = 0.0,
         over_before_ = 0.0;  // [s] largest excess over T, in this window and in the last
  double window_ = 0.0;       // [s] age of this window
  double reserved_ = 0.0, reserved_of_any_hand_ = 0.0;  // [s] beyond T
};

}  // namespace feltwire
