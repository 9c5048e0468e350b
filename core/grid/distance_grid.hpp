#pragma once
// Signed distance on a grid. A query costs the same for every solid.

#include "core/base/types.hpp"
#include "core/geometry/primitive.hpp"
#include "core/grid/brick_samples.hpp"
#include "core/grid/field_group.hpp"

namespace feltwire {

template <class Real>
class DistanceGrid {
 public:
  /// As sample_bricks(), and throws the same.
  DistanceGrid(const Solid& solid, const GridOptions& options)
      : grid_(sample_bricks<Real>(solid, options)) {}

  /// Distance and gradient at a position. Where there are samples, the gradient is exactly that of
  /// the interpolated distance. Beyond the band both are coarse: one value a brick, never below the
  /// band. Never allocates.
  FieldPoint at(const Vec3& position) const noexcept;

  /// [m] A lower bound of sign * distance at the position; `sign` is 1 or -1. It reads one value,
  /// and more only if that value is below `wanted`.
  double at_least(const Vec3& position, double sign, double wanted) const noexcept;

  /// at() and at_least() of eight places. The results are the same up to Real's rounding. `wanted`
  /// has one number for each place.
  void at(FieldGroup& group) const noexcept;
  void at_least(FieldGroup& group, double sign, const FieldGroup::Lanes& wanted) const noexcept;

  double resolution() const { return grid_.h; }
  double band() const { return grid_.band; }
  const Vec3& low() const { return grid_.low; }
  const Vec3& high() const { return grid_.high; }
  /// Number of bricks with samples.
  std::size_t bricks() const { return grid_.values.size() / Samples::kStored; }
  std::size_t bytes() const { return grid_.bytes(); }

 private:
  using Samples = BrickSamples<Real>;
  using Index = Eigen::Vector3i;
  static constexpr int kBrick = Samples::kBrick, kRow = Samples::kRow;
  struct Place;
  bool find(const Vec3& position, Place& place) const noexcept;
  FieldPoint fine(const Place& place, std::int32_t slot) const noexcept;
  FieldPoint coarse(const Place& place) const noexcept;

  Samples grid_;
};

extern template class DistanceGrid<float>;
extern template class DistanceGrid<double>;

}  // namespace feltwire
