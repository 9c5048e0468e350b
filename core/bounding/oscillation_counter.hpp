#pragma once
// Detects that a hand swings in a contact.

#include <cstddef>

#include "core/bounding/reversal_history.hpp"

namespace feltwire {

/// kReversals changes of direction within kWithin are no intended motion: that is a swing of 28 Hz
/// or more, and a hand reaches some 10 Hz.
class OscillationCounter {
 public:
  static constexpr std::size_t kReversals = 6;
  static constexpr double kWithin = 0.09;  // [s]

  /// `swing` [m], the least movement between two reversals.
  explicit OscillationCounter(double swing) : swing_(swing) {}

  /// The hand moved by `way` [m] along the normal of its contact over `time` [s]. True when it
  /// swings; then the count restarts.
  bool moved(double way, double time) noexcept {
    if (!movements_.moved(way, time, swing_)) return false;
    if (movements_.count() < kReversals || movements_.since(kReversals - 1) > kWithin) return false;
    movements_.restart();
    return true;
  }

  /// The hand left the contact.
  void forget() noexcept { movements_ = {}; }

 private:
  double swing_;
  ReversalHistory<kReversals> movements_;
};

}  // namespace feltwire
