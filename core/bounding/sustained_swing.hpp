#pragma once
// Detects that a hand swings and does not come to rest.

#include <cstddef>

#include "core/bounding/movements.hpp"

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
    if (!movements_.moved(way, time, swing, kWithin)) return false;
    double before = 0.0, after = 0.0;  // [m]
    for (std::size_t i = 0; i < kHalf; ++i) {
      before += movements_.length(i);
      after += movements_.length(kHalf + i);
    }
    if (after < kKept * before) return false;
    movements_.restart();
    return true;
  }

 private:
  Movements<2 * kHalf> movements_;
};

}  // namespace feltwire
