#pragma once
// Vector lengths that neither overflow nor underflow. For ordinary numbers they cost as much as a
// plain norm.

#include <cmath>
#include <limits>

#include "core/base/types.hpp"

namespace feltwire {

/// A sum of squares between these limits has neither overflowed nor lost digits to denormals.
template <class Real>
inline constexpr Real kLeastSquare =
    std::numeric_limits<Real>::min() / std::numeric_limits<Real>::epsilon();
template <class Real>
inline constexpr Real kLargestSquare =
    std::numeric_limits<Real>::max() * std::numeric_limits<Real>::epsilon();

template <class Real>
inline bool is_plain_square(Real squared) noexcept {
  return squared > kLeastSquare<Real> && squared < kLargestSquare<Real>;
}

/// v as components below one times 2^exponent, for vectors that are too large or too small to be
/// squared. Zero if v is zero or not finite.
template <class Real>
struct Scaled {
  Vector3<Real> v = Vector3<Real>::Zero();
  int exponent = 0;
};
template <class Real>
Scaled<Real> scaled(const Vector3<Real>& v) noexcept {
  const Real largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !v.allFinite()) return {};
  const int e = std::ilogb(largest) + 1;
  return {{std::ldexp(v.x(), -e), std::ldexp(v.y(), -e), std::ldexp(v.z(), -e)}, e};
}

// The rare cases stand in functions of their own, so that the ordinary ones are inlined.
namespace numeric_detail {

template <class Real>
[[gnu::noinline, gnu::cold]] Real extreme_length(const Vector3<Real>& v) noexcept {
  if (v.isZero(0)) return 0;
  if (!v.allFinite()) return std::abs(v.sum());
  const Scaled<Real> s = scaled(v);
  return std::ldexp(s.v.norm(), s.exponent);
}

}  // namespace numeric_detail

/// |v|, correct for every finite v up to the largest number; not finite if v is not finite.
template <class Derived>
inline typename Derived::Scalar length(const Eigen::MatrixBase<Derived>& expression) noexcept {
  using Real = typename Derived::Scalar;
  const Vector3<Real> v = expression;
  const Real squared = v.squaredNorm();
  if (is_plain_square(squared)) [[likely]]
    return std::sqrt(squared);
  return numeric_detail::extreme_length(v);
}

/// sqrt(a^2 + b^2), correct for every finite a and b.
template <class Real>
inline Real hypotenuse(Real a, Real b) noexcept {
  const Real squared = a * a + b * b;
  if (is_plain_square(squared)) [[likely]]
    return std::sqrt(squared);
  return std::hypot(a, b);
}

/// v as length and unit vector. Both are zero if v is zero or not finite.
template <class Real>
struct Polar {
  Real length = 0;
  Vector3<Real> direction = Vector3<Real>::Zero();
};

namespace numeric_detail {

template <class Real>
[[gnu::noinline, gnu::cold]] Polar<Real> extreme_polar(const Vector3<Real>& v) noexcept {
  if (v.isZero(0)) return {};
  const Scaled<Real> s = scaled(v);
  const Real norm = s.v.norm();
  if (!(norm > 0)) return {};
  return {std::ldexp(norm, s.exponent), s.v / norm};
}

}  // namespace numeric_detail

template <class Real>
inline Polar<Real> polar(const Vector3<Real>& v) noexcept {
  const Real squared = v.squaredNorm();
  if (is_plain_square(squared)) [[likely]] {
    const Real norm = std::sqrt(squared);
    return {norm, v * (1 / norm)};
  }
  return numeric_detail::extreme_polar(v);
}

/// v / |v|. Zero if v is zero or not finite.
template <class Derived>
inline Vector3<typename Derived::Scalar> direction(
    const Eigen::MatrixBase<Derived>& expression) noexcept {
  const Vector3<typename Derived::Scalar> v = expression;
  return polar(v).direction;
}

/// The part of v along the unit vector u.
template <class Derived>
inline Vector3<typename Derived::Scalar> along(
    const Eigen::MatrixBase<Derived>& v, const Vector3<typename Derived::Scalar>& u) noexcept {
  return v.dot(u) * u;
}

}  // namespace feltwire
