#pragma once
// The walls of a corner: their forces, and the share of the damping that each may use.

#include <cmath>

#include "core/base/contact_normals.hpp"

namespace feltwire {

/// Forces and movements by wall, for two walls or three.
///
/// A force in their span is f = sum F_i n_i, with F_i = d_i.f, where d_i.n_j = 1 for i = j, else 0.
/// A movement's share of the damping is weight_i (n_i.dx)^2, with
///   weight_i = 1 / sum_j |n_i.n_j|
/// All shares together never exceed |dx|^2 less the part across all walls (docs/bounding.md,
/// "Corners"). Walls at right angles have weight 1: their shares use all of it.
template <class Real>
class MultiContactFrame {
 public:
  /// Precondition: 2 <= normals.count, filled by ContactNormals::add().
  explicit MultiContactFrame(const ContactNormals& normals) noexcept : count_(normals.count) {
    Mat3 n;
    n << normals.unit[0], normals.unit[1],
        count_ > 2 ? normals.unit[2] : normals.unit[0].cross(normals.unit[1]).normalized();
    // The rows of the inverse, computed without a general solver.
    const double volume = n.col(0).dot(n.col(1).cross(n.col(2)));
    for (int i = 0; i < 3; ++i) {
      const Vec3 dual = n.col((i + 1) % 3).cross(n.col((i + 2) % 3)) / volume;
      normal_.col(i) = n.col(i).template cast<Real>();
      dual_.col(i) = dual.template cast<Real>();
      double beside = 0.0;
      for (int j = 0; j < count_; ++j) beside += std::abs(n.col(i).dot(n.col(j)));
      weight_[i] = static_cast<Real>(1.0 / beside);
    }
  }

  int count() const noexcept { return count_; }
  Vector3<Real> normal(int i) const noexcept { return normal_.col(i); }
  Real weight(int i) const noexcept { return weight_[i]; }
  /// F_i of a force.
  Real part(int i, const Vector3<Real>& force) const noexcept { return dual_.col(i).dot(force); }
  /// The part of v across all walls; zero for three walls.
  Vector3<Real> across(const Vector3<Real>& v) const noexcept {
    return count_ > 2 ? Vector3<Real>(Vector3<Real>::Zero())
                      : Vector3<Real>(v.dot(normal_.col(2)) * normal_.col(2));
  }

 private:
  int count_;
  Matrix3<Real> normal_, dual_;  // columns; with two walls the last one is across both
  Vector3<Real> weight_ = Vector3<Real>::Zero();
};

}  // namespace feltwire
