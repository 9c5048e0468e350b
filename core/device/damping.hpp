#pragma once
// The damping of a device itself. Its energy pays for the force of a bounded port.

#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

/// Viscous damping B of translation [N s/m] or rotation [N m s/rad]: force B v against velocity v.
/// It is equal in every direction (a number), different along the world's axes, or a symmetric
/// positive definite matrix in the world frame. Not checked here: see validate().
class Damping {
 public:
  enum class Kind : std::uint8_t { isotropic, axes, matrix };

  Damping(double b = 0.0) : matrix_(b * Mat3::Identity()) {}  // NOLINT(google-explicit-constructor)
  Damping(const Vec3& axes)                                   // NOLINT(google-explicit-constructor)
      : matrix_(axes.asDiagonal()), kind_(Kind::axes) {}
  Damping(const Mat3& matrix)  // NOLINT(google-explicit-constructor)
      : matrix_(matrix), kind_(Kind::matrix) {}

  Kind kind() const { return kind_; }
  bool isotropic() const { return kind_ == Kind::isotropic; }
  const Mat3& matrix() const { return matrix_; }

  /// The damping in the direction that is damped least: the smallest eigenvalue.
  double least() const;
  /// The damping that each world axis has in every case: the damping along it, or least() if a
  /// matrix couples the axes.
  Vec3 per_axis() const;
  /// dx' B dx; over a hold of h, at least this / h is burned (Cauchy-Schwarz).
  double quadratic(const Vec3& dx) const noexcept {
    return isotropic() ? matrix_(0, 0) * dx.squaredNorm() : dx.dot(matrix_ * dx);
  }

  /// Adds damping, the same in every direction.
  Damping& operator+=(double b) {
    matrix_.diagonal().array() += b;
    return *this;
  }
  friend bool operator==(const Damping&, const Damping&) = default;

 private:
  Mat3 matrix_;
  Kind kind_ = Kind::isotropic;
};

/// Throws std::invalid_argument that begins with `field` and names the remedy, if a number is not
/// finite or negative, or a matrix is not symmetric positive definite.
void validate(const Damping& damping, const char* field);

}  // namespace feltwire
