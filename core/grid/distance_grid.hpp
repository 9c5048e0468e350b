#pragma once
// Signed distance on a grid. A query costs the same for every solid.
//
// The samples lie in bricks of 8 x 8 x 8. Only the bricks near the surface are kept; every other
// brick has one value, the distance at its centre. A brick repeats the samples around it (its
// apron), so that a query reads only one brick.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

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

/// A solid as its box and its signed distance [m], both in one frame. The distance must be exact:
/// between two places it changes by no more than their distance. Several threads call it, and it
/// must not throw.
struct Solid {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // [m] the solid lies between them
  std::function<double(const Vec3&)> distance;
};

/// The interpolation between the samples.
enum class Interpolation : std::uint8_t {
  linear,    // 8 samples; the gradient jumps from cell to cell
  quadratic  // 27 coefficients of a B-spline; the gradient is continuous
};

struct GridOptions {
  double resolution = 1e-3;  // h [m] between samples, > 0
  double band = 0.0;  // [m] about the surface that is sampled at h; 0: one brick, 8 h; never less
  Interpolation interpolation = Interpolation::quadratic;
  std::size_t max_bytes = std::size_t{1} << 30;  // a larger grid is refused
};

template <class Real>
class DistanceGrid {
 public:
  /// Samples the solid, on all cores; the same bits on any number of them. Throws
  /// std::invalid_argument that names resolution, value and remedy if the options or the solid's
  /// box are not possible or the grid would be too large.
  DistanceGrid(const Solid& solid, const GridOptions& options);

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

  double resolution() const { return h_; }
  double band() const { return band_; }
  const Vec3& low() const { return low_; }
  const Vec3& high() const { return high_; }
  std::size_t bricks() const { return values_.size() / kStored; }  // those with samples
  std::size_t bytes() const;

 private:
  static constexpr int kBrick = 8;         // samples along an edge of a brick
  static constexpr int kRow = kBrick + 2;  // with the apron
  static constexpr std::size_t kStored = std::size_t{kRow} * kRow * kRow;
  using Index = Eigen::Vector3i;
  struct Place;
  struct Builder;
  using Offsets = std::array<std::size_t, FieldGroup::kSize>;  // of the first sample, into values_
  using Beyond = std::array<std::array<Real, FieldGroup::kSize>, 3>;  // [h] as Place's, x, y, z

  std::size_t brick_index(const Index& brick) const noexcept;
  bool find(const Vec3& position, Place& place) const noexcept;
  Vec3 center_of(const Index& brick) const noexcept;
  FieldPoint fine(const Place& place, std::int32_t slot) const noexcept;
  FieldPoint coarse(const Place& place) const noexcept;
  bool find(const FieldGroup& group, Offsets& offsets, Beyond& beyond) const noexcept;
  void fine(const Offsets& offsets, const Beyond& beyond, FieldGroup& group) const noexcept;

  double h_ = 0.0, inverse_h_ = 0.0, band_ = 0.0;
  Interpolation interpolation_;
  Vec3 low_, high_;                  // [m] of the solid
  Vec3 origin_;                      // [m] of sample 0, 0, 0
  Index count_ = Index::Zero();      // bricks along x, y, z
  std::vector<std::int32_t> slots_;  // of each brick, x fastest: the place of its samples, or -1
  std::vector<Real> centers_;        // [m] signed distance at each brick's centre
  std::vector<Real> values_;         // [m] samples or coefficients, x fastest, brick by brick
};

extern template class DistanceGrid<float>;
extern template class DistanceGrid<double>;

}  // namespace feltwire
