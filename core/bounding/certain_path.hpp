#pragma once
// A lower bound of the path of a handle, from an encoder that rounds.

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// A lower bound of the true path. A play of half-width q follows each axis; its path is never
/// longer than the true one. A path with the ways X, Y, Z along the axes is at least
/// sqrt(X^2 + Y^2 + Z^2) long, and exactly so long while its direction stays the same. So the ways
/// are counted over windows of kWindow quanta. Each window begins with a play in the middle
/// (docs/bounding.md, "What is guaranteed, and under which assumption").
class CertainPath {
 public:
  static constexpr double kWindow = 64.0;  // q

  /// q [m], the encoder quantum of each world axis.
  explicit CertainPath(double quantum) : quantum_(quantum) {}

  /// Returns the path [m] that this displacement [m] adds.
  double moved(const Vec3& displacement) noexcept {
    slack_ += displacement;
    const Vec3 kept = slack_.cwiseMax(-quantum_).cwiseMin(quantum_);
    if (kept == slack_) return 0.0;
    ways_ += (slack_ - kept).cwiseAbs();
    slack_ = kept;
    const double path = length(ways_), more = path - path_;
    path_ = path;
    if (path_ >= kWindow * quantum_) forget();
    return more;
  }
  /// The last displacement is not known.
  void forget() noexcept {
    slack_.setZero();
    ways_.setZero();
    path_ = 0.0;
  }

 private:
  double quantum_;
  Vec3 slack_ = Vec3::Zero();  // [m] of the play, per axis
  Vec3 ways_ = Vec3::Zero();   // [m] of the play along each axis in this window
  double path_ = 0.0;          // [m] at least, in this window
};

}  // namespace feltwire
