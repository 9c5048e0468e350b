#pragma once
// Vector lengths that neither overflow nor underflow, at the price of a plain norm where the
// numbers are plain.

#include <cmath>

#include "core/types.hpp"

namespace feltwire {

/// |v|, right for every finite v up to the largest double; not finite when v is not.
inline double length(const Vec3& v) noexcept {
  const double squared = v.squaredNorm();
  // Between these the sum of squares has neither overflowed nor lost digits to denormals.
  if (squared > 1e-280 && squared < 1e280) [[likely]]
    return std::sqrt(squared);
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0.0) || !v.allFinite()) return std::abs(v.sum());
  int exponent;
  std::frexp(largest, &exponent);
  return std::ldexp(
      Vec3(std::ldexp(v.x(), -exponent), std::ldexp(v.y(), -exponent), std::ldexp(v.z(), -exponent))
          .norm(),
      exponent);
}

/// sqrt(a^2 + b^2), right for every finite a and b.
inline double hypotenuse(double a, double b) noexcept {
  const double squared = a * a + b * b;
  if (squared > 1e-280 && squared < 1e280) [[likely]]
    return std::sqrt(squared);
  return std::hypot(a, b);
}

/// v / |v|; zero for zero and for what is not finite.
inline Vec3 direction(const Vec3& v) noexcept {
  const double squared = v.squaredNorm();
  if (squared > 1e-280 && squared < 1e280) [[likely]]
    return v / std::sqrt(squared);
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0.0) || !v.allFinite()) return Vec3::Zero();
  int exponent;
  std::frexp(largest, &exponent);
  return Vec3(std::ldexp(v.x(), -exponent), std::ldexp(v.y(), -exponent),
              std::ldexp(v.z(), -exponent))
      .normalized();
}

/// The part of v along the unit vector u.
inline Vec3 along(const Vec3& v, const Vec3& u) noexcept { return v.dot(u) * u; }

}  // namespace feltwire
