#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

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
  void add(const Vec3& x, const Vec3& v, const Vec3& force) noexcept {
    xx_ += x * x.transpose();
    xv_ += x * v.transpose();
    vv_ += v * v.transpose();
    xf_ += x * force.transpose();
    vf_ += v * force.transpose();
    ff_ += force * force.transpose();
    x_ += x;
    v_ += v;
    f_ += force;
    ++count_;
  }
  /// [unit of x] standard deviation of the samples along a unit direction.
  double excitation(const Vec3& direction) const noexcept {
    if (count_ == 0) return 0.0;
    const double mean = x_.dot(direction) / count_;
    return std::sqrt(std::max(0.0, square(xx_, direction) / count_ - mean * mean));
  }
  /// Fits along a unit direction. Zeros if the samples do not determine it.
  Line line(const Vec3& direction) const noexcept {
    constexpr int kLeast = 5;
    if (count_ < kLeast) return {};
    const double x = x_.dot(direction), v = v_.dot(direction), f = f_.dot(direction);
    const double squares = square(ff_, direction);
    const double variation = squares - f * f / count_;
    if (!(variation > 0.0)) return {};
    const double xv = square(xv_, direction);
    const Vec3 right(square(xf_, direction), square(vf_, direction), f);
    Mat3 normal;
    normal << square(xx_, direction), xv, x, xv, square(vv_, direction), v, x, v, count_;
    // The speed is smaller by the scale of one second: weight it so that the smallest pivot is not
    // noise.
    Mat3 damped = normal;
    damped(1, 1) += kSpeedPrior * count_;
    const Vec3 solution = damped.ldlt().solve(right);
    if (!solution.allFinite()) return {};
    const double left = squares - 2.0 * solution.dot(right) + solution.dot(normal * solution);
    return {solution.x(), 1.0 - std::max(0.0, left) / variation};
  }

 private:
  static constexpr double kSpeedPrior = 1e-6;  // [m^2/s^2]
  static double square(const Mat3& sums, const Vec3& direction) noexcept {
    return direction.dot(sums * direction);
  }
  Mat3 xx_ = Mat3::Zero(), xv_ = Mat3::Zero(), vv_ = Mat3::Zero();
  Mat3 xf_ = Mat3::Zero(), vf_ = Mat3::Zero(), ff_ = Mat3::Zero();
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), f_ = Vec3::Zero();
  int count_ = 0;
};

}  // namespace feltwire
