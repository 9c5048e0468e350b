#pragma once
// Coordinates in which a damping is the same in every direction.

#include <Eigen/Cholesky>

#include "core/bounding/step.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

/// With B = b L L' (Cholesky, b the mean of B's diagonal) and
///   y = L' dx,   g = L^-1 f
/// work stays work, f.dx = g.y, and the damping is a number, dx' B dx = b |y|^2. So every law that
/// was proven for a number b holds for g and y, and |g|^2 = b f' B^-1 f: the metric of B^-1
/// (docs/bounding.md, "A damping that differs by direction").
template <class Real>
class Metric {
 public:
  /// Precondition: validate(damping) passed. A damping that is not usable() gives the identity.
  explicit Metric(const Damping& damping)
      : euclidean_(damping.isotropic()),
        b_(static_cast<Real>(euclidean_ ? damping.matrix()(0, 0)
                                        : damping.matrix().trace() / 3.0)) {
    if (euclidean_ || !usable(damping)) return;
    const Mat3 lower = (damping.matrix() / (damping.matrix().trace() / 3.0)).llt().matrixL();
    back_ = lower.cast<Real>();
    forth_ = lower.inverse().eval().cast<Real>();
  }

  /// Whether every direction is damped, or none is.
  static bool usable(const Damping& damping) {
    return damping.isotropic() || damping.least() > 0.0;
  }

  bool euclidean() const noexcept { return euclidean_; }
  Real damping() const noexcept { return b_; }  // b

  Vector3<Real> force(const Vector3<Real>& f) const noexcept {  // g
    return euclidean_ ? f : Vector3<Real>(forth_ * f);
  }
  Vector3<Real> movement(const Vector3<Real>& dx) const noexcept {  // y
    return euclidean_ ? dx : Vector3<Real>(back_.transpose() * dx);
  }
  Vector3<Real> force_back(const Vector3<Real>& g) const noexcept {
    return euclidean_ ? g : Vector3<Real>(back_ * g);
  }

  /// The movement that takes the most energy from a port over `hold_time` while f is held: dx =
  /// B^-1 f h / 2 minimises dx' B dx / h - f.dx. Zero without damping.
  Vector3<Real> worst_movement(const Vector3<Real>& f, Real hold_time) const noexcept {
    if (!(b_ > 0)) return Vector3<Real>::Zero();
    const Vector3<Real> g = (hold_time / (2 * b_)) * force(f);
    return euclidean_ ? g : Vector3<Real>(forth_.transpose() * g);
  }

 private:
  bool euclidean_;
  Real b_;
  Matrix3<Real> forth_ = Matrix3<Real>::Identity(), back_ = Matrix3<Real>::Identity();
};

}  // namespace feltwire
