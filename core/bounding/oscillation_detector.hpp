#pragma once
// Detects that a hand swings and does not come to rest.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/bounding/reversal_history.hpp"

namespace feltwire {

enum class Oscillation : std::uint8_t { none, slow, fast };

/// A hand that lands hard on a stiff wall bounces, and each bounce is smaller than the one before.
/// A hand that swings because the wall is too stiff for it goes on. This class tells them apart by
/// the last movements: the newer half of them is together nearly as long as the older half.
///
/// A fast swing (46 Hz or more) is what a force causes that is held for a sample. A slow swing (11
/// to 46 Hz, of twice the least size) is what a motor causes that follows its command late. A hand
/// does not move to and fro as fast by itself: tapping and tremor are slower. A swing that leaves
/// the contact and comes back counts too.
class OscillationDetector {
 public:
  /// How many movements there are in half of them, the share of its length that is kept from half
  /// to half, and the time within which the movements end [s].
  struct Kind {
    std::size_t half;
    double kept, beyond, within;
  };
  static constexpr Kind kFast = {.half = 6, .kept = 0.95, .beyond = 0.0, .within = 0.12};
  static constexpr Kind kSlow = {.half = 3, .kept = 0.8, .beyond = 0.055, .within = 0.22};
  static constexpr double kSlowSize = 2.0;  // of the least movement

  /// The hand moved by `way` [m] along the normal of its contact over `time` [s]; `swing` [m] is
  /// the least movement between two reversals. Not `none` when it swings; then the count restarts.
  Oscillation moved(double way, double time, double swing) noexcept {
    if (!movements_.moved(way, time, swing)) return Oscillation::none;
    const Oscillation found = sustained(kFast, swing)               ? Oscillation::fast
                              : sustained(kSlow, kSlowSize * swing) ? Oscillation::slow
                                                                    : Oscillation::none;
    if (found != Oscillation::none) movements_.restart();
    return found;
  }

 private:
  bool sustained(const Kind& kind, double least) const noexcept {
    if (movements_.count() < 2 * kind.half) return false;
    const double time = movements_.since(2 * kind.half - 1);
    if (time < kind.beyond || time > kind.within) return false;
    double before = 0.0, after = 0.0;  // [m]
    for (std::size_t i = 0; i < kind.half; ++i) {
      const double newer = movements_.length(i), older = movements_.length(kind.half + i);
      if (std::min(newer, older) < least) return false;
      after += newer;
      before += older;
    }
    return after >= kind.kept * before;
  }

  ReversalHistory<2 * kFast.half> movements_;
};

}  // namespace feltwire
