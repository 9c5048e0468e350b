#pragma once
// Least squares of a spring and a damper.

#include "core/base/types.hpp"

namespace feltwire {

/// Least squares of F = k x + b v + a over samples (x, v, F), a spring and a damper, along any
/// direction. The samples are stored as vectors, and the direction is an argument of the result. So
/// the samples stay valid while the direction is still estimated.
class LineFit {
 public:
  struct Line {
    double slope = 0.0;      // k
    double explained = 0.0;  // r^2, 0 to 1
  };

  void clear() noexcept { *this = {}; }
  void add(const Vec3& x, const Vec3& v, const Vec3& force) noexcept;
  /// [unit of x] standard deviation of the samples along a unit direction.
  double excitation(const Vec3& direction) const noexcept;
  /// Fits along a unit direction. Zeros if the samples do not determine it.
  Line line(const Vec3& direction) const noexcept;

 private:
  Mat3 xx_ = Mat3::Zero(), xv_ = Mat3::Zero(), vv_ = Mat3::Zero();
  Mat3 xf_ = Mat3::Zero(), vf_ = Mat3::Zero(), ff_ = Mat3::Zero();
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), f_ = Vec3::Zero();
  int count_ = 0;
};

}  // namespace feltwire
