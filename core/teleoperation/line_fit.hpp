#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/types.hpp"

namespace feltwire {

/// Least squares of F = k x + b v + a over samples (x, v, F): a spring and a damper.
class LineFit {
 public:
  struct Line {
    double slope = 0.0;      // k
    double explained = 0.0;  // r^2, 0 to 1
  };

  void clear() noexcept { *this = {}; }
  void add(double x, double v, double force) noexcept {
    const Eigen::Vector3d row(x, v, 1.0);
    normal_ += row * row.transpose();
    right_ += force * row;
    squares_ += force * force;
    ++count_;
  }
  /// [unit of x] standard deviation of the samples.
  double excitation() const noexcept {
    if (count_ == 0) return 0.0;
    const double mean = normal_(0, 2) / count_;
    return std::sqrt(std::max(0.0, normal_(0, 0) / count_ - mean * mean));
  }
  /// Zeros where the samples do not determine it.
  Line line() const noexcept {
    constexpr int kLeast = 5;
    if (count_ < kLeast) return {};
    const double mean = right_(2) / count_;
    const double variation = squares_ - count_ * mean * mean;
    if (!(variation > 0.0)) return {};
    // The speed has the scale of a second fewer: weight it so that the smallest pivot is not noise.
    Mat3 damped = normal_;
    damped(1, 1) += kSpeedPrior * count_;
    const Vec3 solution = damped.ldlt().solve(right_);
    if (!solution.allFinite()) return {};
    const double left = squares_ - 2.0 * solution.dot(right_) + solution.dot(normal_ * solution);
    return {solution.x(), 1.0 - std::max(0.0, left) / variation};
  }

 private:
  static constexpr double kSpeedPrior = 1e-6;  // [m^2/s^2]
  Mat3 normal_ = Mat3::Zero();
  Vec3 right_ = Vec3::Zero();
  double squares_ = 0.0;
  int count_ = 0;
};

}  // namespace feltwire
