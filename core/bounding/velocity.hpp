#pragma once

#include <cmath>
#include <numbers>

#include "core/base/types.hpp"

namespace feltwire {

/// Velocity of a sampled position: backward difference, then a first-order low-pass (exact for a
/// held input). Encoder quanta make the bare difference jump by quantum / T; the cut-off trades
/// that noise against lag.
class VelocityEstimate {
 public:
  /// cutoff [Hz]; 0 or less means no filter.
  explicit VelocityEstimate(double cutoff = 0.0) : cutoff_(cutoff) {}

  /// Returns the velocity [m/s] after a displacement [m] over a time [s]. A time that is not above
  /// zero, and any value that is not finite, changes nothing.
  const Vec3& update(const Vec3& displacement, double time) noexcept {
    if (!(time > 0.0)) return velocity_;
    const Vec3 difference = displacement / time;
    if (!difference.allFinite())
      return velocity_;  // otherwise it would stay in the filter for ever
    if (!(cutoff_ > 0.0)) return velocity_ = difference;
    const double blend = -std::expm1(-2.0 * std::numbers::pi * cutoff_ * time);
    return velocity_ += blend * (difference - velocity_);
  }
  const Vec3& value() const { return velocity_; }

 private:
  double cutoff_;
  Vec3 velocity_ = Vec3::Zero();
};

}  // namespace feltwire
