#pragma once
// The commanded opening of a robot's gripper, from the hand's lever.

#include <algorithm>
#include <cmath>

namespace feltwire {

struct GripperLimits {
  double speed = 0.2;      // [m/s]
  double catch_up = 0.02;  // [m/s] until it has reached the lever's place, after the hand engaged
};

/// A hand that engages may have its lever at any place. So the gripper moves slowly from its
/// present command to the lever's place. Once it has been there, it follows at full speed. It never
/// jumps.
///
/// No function allocates, throws or reads a clock.
class GripperFollow {
 public:
  /// Precondition: the limits are finite and positive, `widest` [m] >= 0. 0: there is no gripper.
  GripperFollow(const GripperLimits& limits, double widest) : limits_(limits), widest_(widest) {}

  /// Sets the present command [m].
  void begin(double opening) noexcept { opening_ = opening; }
  /// A hand begins to lead.
  void engage() noexcept {
    caught_up_ = false;
    way_ = 0.0;
  }

  /// Returns the command for the next `elapsed` [s]. `wanted` [m] within its range; if it is below
  /// zero or not finite, the gripper stays.
  double step(double wanted, double elapsed) noexcept {
    if (!(wanted >= 0.0) || !std::isfinite(wanted) || widest_ == 0.0) return opening_;
    const double way = std::min(wanted, widest_) - opening_;
    const double most = (caught_up_ ? limits_.speed : limits_.catch_up) * elapsed;
    caught_up_ |= std::abs(way) <= most || way * way_ < 0.0;  // also if the lever passes it
    way_ = way;
    return opening_ += std::clamp(way, -most, most);
  }

 private:
  GripperLimits limits_;
  double widest_;
  double opening_ = 0.0;  // [m]
  double way_ = 0.0;  // [m] distance to the wanted opening in the last step, since the hand engaged
  bool caught_up_ = false;
};

}  // namespace feltwire
