#pragma once
// Detects that a hand swings and does not come to rest.

#include <array>
#include <cstddef>

#include "core/bounding/swing_counter.hpp"

namespace feltwire {

/// A hand that lands hard on a stiff wall bounces, and each bounce is smaller than the one before.
/// A hand that swings because the wall is too stiff for it goes on. This class tells them apart: it
/// swings where its last kHalf movements are together at least kKept times as long as the kHalf
/// before them, all of them within kWithin (46 Hz or more: a held force does not cause slower
/// swings). A swing that leaves the contact and comes back counts too.
class SustainedSwing {
 public:
  static constexpr std::size_t kHalf = 6;
  static constexpr double kKept = 0.95;
  static constexpr double kWithin = 0.12;  // [s]

  /// The hand moved by `way` [m] along the normal of its contact over `time` [s]; `swing` [m] is
  /// the least movement between two reversals. True when it swings; then the count restarts.
  bool moved(double way, double time, double swing) noexcept {
    now_ += time;
    const double length = reversals_.moved(way, swing);
    return length > 0.0 && reversed(length);
  }

 private:
  struct Movement {
    double end = 0.0;     // [s]
    double length = 0.0;  // [m]
  };
  bool reversed(double length) noexcept {
    movements_[next_] = {now_, length};
    next_ = (next_ + 1) % movements_.size();  // now the index of the oldest
    if (counted_ < movements_.size()) ++counted_;
    if (counted_ < movements_.size() || now_ - movements_[next_].end > kWithin) return false;
    double before = 0.0, after = 0.0;  // [m]
    for (std::size_t i = 0; i < movements_.size(); ++i)
      (i < kHalf ? before : after) += movements_[(next_ + i) % movements_.size()].length;
    if (after < kKept * before) return false;
    counted_ = 0;
    return true;
  }

  Reversals reversals_;
  double now_ = 0.0;                             // [s]
  std::array<Movement, 2 * kHalf> movements_{};  // the last ones, a ring
  std::size_t next_ = 0, counted_ = 0;
};

}  // namespace feltwire
