#include "core/teleoperation/line_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

constexpr double kSpeedPrior = 1e-6;  // [m^2/s^2] prior weight of the speed terms

double square(const Mat3& sums, const Vec3& direction) noexcept {
  return direction.dot(sums * direction);
}

}  // namespace

void LineFit::add(const Vec3& x, const Vec3& v, const Vec3& force) noexcept {
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

double LineFit::excitation(const Vec3& direction) const noexcept {
  if (count_ == 0) return 0.0;
  const double mean = x_.dot(direction) / count_;
  return std::sqrt(std::max(0.0, square(xx_, direction) / count_ - mean * mean));
}

LineFit::Line LineFit::line(const Vec3& direction) const noexcept {
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
  // The speed terms may be very small. A prior weight keeps the smallest pivot above the noise.
  Mat3 damped = normal;
  damped(1, 1) += kSpeedPrior * count_;
  const Vec3 solution = damped.ldlt().solve(right);
  if (!solution.allFinite()) return {};
  const double left = squares - 2.0 * solution.dot(right) + solution.dot(normal * solution);
  return {solution.x(), 1.0 - std::max(0.0, left) / variation};
}

}  // namespace feltwire
