#pragma once
// A lower bound of the path of a handle, from an encoder that rounds.

#include <numbers>

#include "core/base/types.hpp"

namespace feltwire {

/// A lower bound of the true path. A play of half-width q follows each axis; its path is never
/// longer than the true one. A path in space is at least (|x| + |y| + |z|) / sqrt(3).
class PathLowerBound {
 public:
  /// q [m], the encoder quantum of each world axis.
  explicit PathLowerBound(double quantum) : quantum_(quantum) {}

  /// Returns the path [m] that this displacement [m] adds.
  double moved(const Vec3& displacement) noexcept {
    slack_ += displacement;
    const Vec3 kept = slack_.cwiseMax(-quantum_).cwiseMin(quantum_);
    const double followed = (slack_ - kept).lpNorm<1>() * std::numbers::inv_sqrt3;
    slack_ = kept;
    return followed;
  }
  /// The last displacement is not known.
  void forget() noexcept { slack_.setZero(); }

 private:
  double quantum_;
  Vec3 slack_ = Vec3::Zero();  // [m] of the play, per axis
};

}  // namespace feltwire
