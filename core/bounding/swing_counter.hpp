#pragma once
// Detects that a hand swings in a contact.

#include <algorithm>
#include <array>
#include <cstddef>

namespace feltwire {

/// A reversal is a change of direction after a movement of more than `swing` [m]. kReversals of
/// them within kWithin are no intended motion: that is a swing of 28 Hz or more, and a hand reaches
/// some 10 Hz.
class SwingCounter {
 public:
  static constexpr std::size_t kReversals = 6;
  static constexpr double kWithin = 0.09;  // [s]

  explicit SwingCounter(double swing) : swing_(swing) {}

  /// The hand moved by `way` [m] along the normal of its contact over `time` [s]. True when it
  /// swings; then the count restarts.
  bool moved(double way, double time) noexcept {
    place_ += way;
    now_ += time;
    highest_ = direction_ < 0 ? highest_ : std::max(highest_, place_);
    lowest_ = direction_ > 0 ? lowest_ : std::min(lowest_, place_);
    if (direction_ >= 0 && place_ < highest_ - swing_) return reversed(-1);
    if (direction_ <= 0 && place_ > lowest_ + swing_) return reversed(1);
    return false;
  }

  /// The hand left the contact.
  void forget() noexcept { *this = SwingCounter(swing_); }

 private:
  bool reversed(int direction) noexcept {
    direction_ = direction;
    highest_ = lowest_ = place_;
    times_[next_] = now_;
    next_ = (next_ + 1) % kReversals;  // now the index of the oldest
    if (counted_ < kReversals) ++counted_;
    if (counted_ < kReversals || now_ - times_[next_] > kWithin) return false;
    counted_ = 0;
    return true;
  }

  double swing_;
  double place_ = 0.0;                      // [m] along the normal, since the contact began
  double highest_ = 0.0, lowest_ = 0.0;     // [m] since the last reversal
  int direction_ = 0;                       // of the motion; 0: not known yet
  double now_ = 0.0;                        // [s] in this contact
  std::array<double, kReversals> times_{};  // [s] of the last reversals, a ring
  std::size_t next_ = 0, counted_ = 0;
};

}  // namespace feltwire
