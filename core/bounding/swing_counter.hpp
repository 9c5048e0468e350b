#pragma once
// Detects that a hand swings in a contact.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace feltwire {

/// The movements of a hand along a line, from one change of direction to the next.
class Reversals {
 public:
  /// The hand moved by `way` [m]. Returns how far it had moved in one direction [m] where it now
  /// has moved back by more than `swing` > 0 [m], else 0.
  double moved(double way, double swing) noexcept {
    place_ += way;
    highest_ = direction_ < 0 ? highest_ : std::max(highest_, place_);
    lowest_ = direction_ > 0 ? lowest_ : std::min(lowest_, place_);
    if (direction_ >= 0 && place_ < highest_ - swing) return reversed(-1, highest_, swing);
    if (direction_ <= 0 && place_ > lowest_ + swing) return reversed(1, lowest_, swing);
    return 0.0;
  }

 private:
  double reversed(int direction, double end, double swing) noexcept {
    const double length = std::abs(end - end_);
    direction_ = direction;
    highest_ = lowest_ = place_;
    end_ = end;
    return std::max(length, swing);
  }

  double place_ = 0.0;                   // [m] since the beginning
  double highest_ = 0.0, lowest_ = 0.0;  // [m] since the last reversal
  double end_ = 0.0;                     // [m] of the movement before the last reversal
  int direction_ = 0;                    // of the motion; 0: not known yet
};

/// kReversals changes of direction within kWithin are no intended motion: that is a swing of 28 Hz
/// or more, and a hand reaches some 10 Hz.
class SwingCounter {
 public:
  static constexpr std::size_t kReversals = 6;
  static constexpr double kWithin = 0.09;  // [s]

  /// `swing` [m], the least movement between two reversals.
  explicit SwingCounter(double swing) : swing_(swing) {}

  /// The hand moved by `way` [m] along the normal of its contact over `time` [s]. True when it
  /// swings; then the count restarts.
  bool moved(double way, double time) noexcept {
    now_ += time;
    return reversals_.moved(way, swing_) > 0.0 && reversed();
  }

  /// The hand left the contact.
  void forget() noexcept { *this = SwingCounter(swing_); }

 private:
  bool reversed() noexcept {
    times_[next_] = now_;
    next_ = (next_ + 1) % kReversals;  // now the index of the oldest
    if (counted_ < kReversals) ++counted_;
    if (counted_ < kReversals || now_ - times_[next_] > kWithin) return false;
    counted_ = 0;
    return true;
  }

  double swing_;
  Reversals reversals_;
  double now_ = 0.0;                        // [s] in this contact
  std::array<double, kReversals> times_{};  // [s] of the last reversals, a ring
  std::size_t next_ = 0, counted_ = 0;
};

}  // namespace feltwire
