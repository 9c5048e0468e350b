#pragma once

#include "core/base/types.hpp"
#include "core/geometry/primitive.hpp"

namespace feltwire {

/// Eight places and the values of a field there. Places near each other cost less together.
struct FieldGroup {
  static constexpr std::size_t kSize = 8;
  using Lanes = Eigen::Array<double, kSize, 1>;
  Lanes x, y, z;                                       // [m] the places; all eight must be given
  Lanes distance, gradient_x, gradient_y, gradient_z;  // as FieldPoint

  Vec3 place(std::size_t lane) const noexcept {
    const auto l = static_cast<Eigen::Index>(lane);
    return {x[l], y[l], z[l]};
  }
  void put(std::size_t lane, const Vec3& place) noexcept {
    const auto l = static_cast<Eigen::Index>(lane);
    x[l] = place.x();
    y[l] = place.y();
    z[l] = place.z();
  }
  void put(std::size_t lane, const FieldPoint& point) noexcept {
    const auto l = static_cast<Eigen::Index>(lane);
    distance[l] = point.distance;
    gradient_x[l] = point.gradient.x();
    gradient_y[l] = point.gradient.y();
    gradient_z[l] = point.gradient.z();
  }
};

}  // namespace feltwire
