#include "core/grid/distance_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/grid/distance_group.hpp"

namespace feltwire {
namespace {

/// Four numbers. A stencil has three samples along x, so the fourth number has weight zero.
template <class Real>
using Row = Eigen::Array<Real, 4, 1>;

/// Weights of the samples before, at and after the nearest sample, and their derivatives. The
/// offset t from the nearest sample is in [-1/2, 1/2].
template <class Real>
struct Weights {
  Row<Real> value = Row<Real>::Zero(), slope = Row<Real>::Zero();
};

template <class Real>
Weights<Real> weights(Interpolation interpolation, Real t) noexcept {
  Weights<Real> w;
  const Real half(0.5);
  if (interpolation == Interpolation::quadratic) {
    const Real before = half - t, after = half + t;
    w.value << half * before * before, Real(0.75) - t * t, half * after * after, 0;
    w.slope << -before, -2 * t, after, 0;
  } else if (t < 0) {
    w.value << -t, 1 + t, 0, 0;
    w.slope << -1, 1, 0, 0;
  } else {
    w.value << 0, 1 - t, t, 0;
    w.slope << 0, -1, 1, 0;
  }
  return w;
}

/// Returns the value and the gradient (per grid step) from 3 x 3 rows. `first` is the row of the
/// lowest samples along y and z. Each row must have a readable fourth number.
template <class Real>
FieldPoint evaluate(const Real* first, std::ptrdiff_t along_y, std::ptrdiff_t along_z,
                    const std::array<Weights<Real>, 3>& w) noexcept {
  Row<Real> value = Row<Real>::Zero(), slope_y = value, slope_z = value;
  for (int z = 0; z < 3; ++z) {
    Row<Real> row_value = Row<Real>::Zero(), row_slope = row_value;
    for (int y = 0; y < 3; ++y) {
      const Eigen::Map<const Row<Real>> row(first + z * along_z + y * along_y);
      row_value += w[1].value[y] * row;
      row_slope += w[1].slope[y] * row;
    }
    value += w[2].value[z] * row_value;
    slope_y += w[2].value[z] * row_slope;
    slope_z += w[2].slope[z] * row_value;
  }
  const Row<Real>& across = w[0].value;
  return {static_cast<double>((across * value).sum()),
          Vec3(static_cast<double>((w[0].slope * value).sum()),
               static_cast<double>((across * slope_y).sum()),
               static_cast<double>((across * slope_z).sum()))};
}

}  // namespace

/// A position in grid coordinates.
template <class Real>
struct DistanceGrid<Real>::Place {
  Index nearest;  // index of the nearest sample
  Index brick;
  Vec3 beyond;  // [h] offset from the nearest sample
  std::size_t at = 0;
};

template <class Real>
bool DistanceGrid<Real>::find(const Vec3& position, Place& place) const noexcept {
  // Add half a step, so that the integer part is the index of the nearest sample.
  const Vec3 u = grid_.inverse_h * (position - grid_.origin) + Vec3::Constant(0.5);
  const bool in = u.x() >= 0.0 && u.y() >= 0.0 && u.z() >= 0.0 &&
                  u.x() < kBrick * grid_.count.x() && u.y() < kBrick * grid_.count.y() &&
                  u.z() < kBrick * grid_.count.z();
  if (!in) return false;  // This is also the result for NaN.
  place.nearest = u.cast<int>();
  place.brick = Index(place.nearest.x() >> Samples::kShift, place.nearest.y() >> Samples::kShift,
                      place.nearest.z() >> Samples::kShift);
  place.beyond = u - Vec3::Constant(0.5) - place.nearest.template cast<double>();
  place.at = grid_.brick_index(place.brick);
  return true;
}

template <class Real>
FieldPoint DistanceGrid<Real>::fine(const Place& place, std::int32_t slot) const noexcept {
  const Index own(place.nearest.x() & (kBrick - 1), place.nearest.y() & (kBrick - 1),
                  place.nearest.z() & (kBrick - 1));
  std::array<Weights<Real>, 3> w;
  for (std::size_t axis = 0; axis < w.size(); ++axis)
    w[axis] = weights(grid_.interpolation,
                      static_cast<Real>(place.beyond[static_cast<Eigen::Index>(axis)]));
  const Real* first =
      &grid_.values[static_cast<std::size_t>(slot) * Samples::kStored +
                    static_cast<std::size_t>((own.z() * kRow + own.y()) * kRow + own.x())];
  FieldPoint point = evaluate<Real>(first, kRow, kRow * kRow, w);
  point.gradient *= grid_.inverse_h;
  return point;
}

/// Applies the same spline to the centres of the bricks. The coefficients are the values
/// themselves, so the result never exceeds their range.
template <class Real>
FieldPoint DistanceGrid<Real>::coarse(const Place& place) const noexcept {
  constexpr std::ptrdiff_t kLanes = 4, kSide = 3;
  std::array<Real, std::size_t{kSide * kSide * kLanes}> around{};
  std::size_t n = 0;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const Index brick = place.brick + Index(x, y, z);
        around[n++] = grid_.centers[grid_.brick_index(
            brick.cwiseMax(0).cwiseMin(grid_.count - Index::Ones()))];
      }
      ++n;
    }
  const Vec3 steps = (place.nearest - kBrick * place.brick).template cast<double>() + place.beyond;
  const Vec3 t = (steps - Vec3::Constant(0.5 * (kBrick - 1))) / kBrick;
  std::array<Weights<Real>, 3> w;
  for (std::size_t axis = 0; axis < w.size(); ++axis)
    w[axis] =
        weights(Interpolation::quadratic, static_cast<Real>(t[static_cast<Eigen::Index>(axis)]));
  FieldPoint point = evaluate<Real>(around.data(), kLanes, kSide * kLanes, w);
  point.gradient *= grid_.inverse_h / kBrick;
  // In a brick without samples, every point is farther from the surface than the band.
  point.distance = grid_.centers[place.at] > 0 ? std::max(point.distance, grid_.band)
                                               : std::min(point.distance, -grid_.band);
  return point;
}

template <class Real>
FieldPoint DistanceGrid<Real>::at(const Vec3& position) const noexcept {
  Place place;
  if (find(position, place)) [[likely]] {
    const std::int32_t slot = grid_.slots[place.at];
    return slot >= 0 ? fine(place, slot) : coarse(place);
  }
  if (!position.allFinite()) return {std::numeric_limits<double>::quiet_NaN(), Vec3::Zero()};
  const Vec3 way = position - position.cwiseMax(grid_.low).cwiseMin(grid_.high);
  const Polar<double> out = polar(way);
  return {out.length, out.direction};
}

template <class Real>
double DistanceGrid<Real>::at_least(const Vec3& position, double sign,
                                    double wanted) const noexcept {
  Place place;
  if (!find(position, place)) {
    const double out = length(position - position.cwiseMax(grid_.low).cwiseMin(grid_.high));
    return sign > 0.0 && std::isfinite(out) ? out : -std::numeric_limits<double>::infinity();
  }
  const double quick = sign * static_cast<double>(grid_.centers[place.at]) -
                       (position - grid_.center_of(place.brick)).norm();
  const std::int32_t slot = grid_.slots[place.at];
  if (quick > wanted || slot < 0) return quick;
  // The interpolation error is less than a grid step, at the sharpest edges of the solid.
  return std::max(quick, sign * fine(place, slot).distance - grid_.h);
}

template <class Real>
void DistanceGrid<Real>::at(FieldGroup& group) const noexcept {
  if (evaluate_group(grid_, group)) [[likely]]
    return;
  for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
    group.put(lane, at(group.place(lane)));
}

template <class Real>
void DistanceGrid<Real>::at_least(FieldGroup& group, double sign,
                                  const FieldGroup::Lanes& wanted) const noexcept {
  if (evaluate_group(grid_, group)) {
    group.distance = sign * group.distance - grid_.h;  // as for a single place
    return;
  }
  for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
    const auto l = static_cast<Eigen::Index>(lane);
    group.distance[l] = at_least(group.place(lane), sign, wanted[l]);
  }
}

template class DistanceGrid<float>;
template class DistanceGrid<double>;

}  // namespace feltwire
