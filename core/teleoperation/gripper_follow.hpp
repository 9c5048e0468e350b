#pragma once
// The opening of a robot's gripper, from what a hand wants.

#include <algorithm>
#include <cmath>

namespace feltwire {

struct GripperLimits {
  double speed = 0.2;      // [m/s]
  double catch_up = 0.02;  // [m/s] until it is where the hand wants it, after the hand engaged
};

/// A hand that engages has its lever anywhere. So the gripper goes there slowly, from what it is
/// told to be; once it has been where the lever is, it follows at speed. It never jumps.
///
/// Nothing here allocates, throws or reads a clock.
class GripperFollow {
 public:
  /// Precondition: the limits are finite and positive. `widest` [m] >= 0: 0: there is no gripper.
  GripperFollow(const GripperLimits& limits, double widest) : limits_(limits), widest_(widest) {}

  /// It is told to be so wide [m].
  void begin(double opening) noexcept { opening_ = opening; }
  /// A hand begins to lead.
  void engage() noexcept {
    caught_up_ = false;
    way_ = 0.0;
  }

  /// What to tell it for the next `elapsed` [s]. `wanted` [m], within its range; below zero or not
  /// finite: it stays.
  double step(double wanted, double elapsed) noexcept {
    if (!(wanted >= 0.0) || !std::isfinite(wanted) || widest_ == 0.0) return opening_;
    const double way = std::min(wanted, widest_) - opening_;
    const double most = (caught_up_ ? limits_.speed : limits_.catch_up) * elapsed;
    caught_up_ |= std::abs(way) <= most || way * way_ < 0.0;  // a lever that passes it, too
    way_ = way;
    return opening_ += std::clamp(way, -most, most);
  }

 private:
  GripperLimits limits_;
  double widest_;
  double opening_ = 0.0;  // [m]
  double way_ = 0.0;      // [m] to what was wanted in the last step, since the hand engaged
  bool caught_up_ = false;
};

}  // namespace feltwire
