#include "core/grid/distance_grid.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"
#include "core/base/parallel.hpp"

namespace feltwire {
namespace {

constexpr int kBrickShift = 3, kBrickMask = 7;
constexpr double kMaxBricksAlong = 1 << 20;  // Every index fits an int.
/// Half the diagonal of a brick's cells, in grid steps. No point of a brick is farther from its
/// centre.
const double kBrickReach = 4.0 * std::sqrt(3.0);

std::string text(double value) {
  std::array<char, 32> characters;
  const auto end =
      std::to_chars(characters.data(), characters.data() + characters.size(), value).ptr;
  return {characters.data(), end};
}

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
struct DistanceGrid<Real>::Builder {
  DistanceGrid& grid;
  const Solid& solid;
  std::vector<Index> bricks;  // bricks with samples, in table order
  std::vector<Real> raw;      // samples of these bricks, without aprons (borders)

  static constexpr std::size_t kOwn = std::size_t{kBrick} * kBrick * kBrick;
  static constexpr int kWide = kBrick + 4;  // brick with an apron of two samples
  using Wide = std::array<double, std::size_t{kWide} * kWide * kWide>;

  double distance(const Index& sample) const {
    return solid.distance(grid.origin_ + grid.h_ * sample.cast<double>());
  }
  Index brick_of(std::size_t at) const {
    const auto nx = static_cast<std::size_t>(grid.count_.x()),
               ny = static_cast<std::size_t>(grid.count_.y());
    return {static_cast<int>(at % nx), static_cast<int>(at / nx % ny),
            static_cast<int>(at / nx / ny)};
  }

  void place(const GridOptions& options);
  void choose(std::size_t max_bytes);
  void sample(std::size_t slot);
  double known(const Index& sample) const;
  void store(std::size_t slot);
};

/// Determines the extent and the table of the grid.
template <class Real>
void DistanceGrid<Real>::Builder::place(const GridOptions& options) {
  const double h = options.resolution;
  if (!(h > 0.0) || !std::isfinite(h))
    throw std::invalid_argument("resolution: must be above zero [m], is " + text(h) +
                                "; give the distance between samples");
  if (!(options.band >= 0.0) || !std::isfinite(options.band))
    throw std::invalid_argument("band: must be at least zero [m], is " + text(options.band) +
                                "; leave it out or give a depth");
  const Vec3 extent = solid.high - solid.low;
  if (!extent.allFinite() || !(extent.minCoeff() >= 0.0))
    throw std::invalid_argument(
        "the solid has no extent that could be sampled; give one that is bounded");
  grid.h_ = h;
  grid.inverse_h_ = 1.0 / h;
  grid.band_ = std::max(options.band, kBrick * h);
  grid.interpolation_ = options.interpolation;
  grid.low_ = solid.low;
  grid.high_ = solid.high;

  const double brick = kBrick * h;
  const Vec3 wanted = ((extent.array() + 2.0 * (grid.band_ + h)) / brick).ceil();
  const double entries = wanted.prod();
  const double bytes = entries * (sizeof(std::int32_t) + sizeof(Real));
  const auto limit = static_cast<double>(options.max_bytes);
  if (!(wanted.maxCoeff() < kMaxBricksAlong) || !(bytes < limit))
    throw std::invalid_argument(
        "resolution: " + text(h) + " m over an extent of " + text(extent.maxCoeff()) +
        " m takes more than the limit of " + text(limit / (1 << 20)) +
        " MiB; give a larger one, at least " +
        text(h * std::max(1.5 * std::cbrt(bytes / limit), wanted.maxCoeff() / kMaxBricksAlong)));
  grid.count_ = wanted.cast<int>();
  grid.origin_ = 0.5 * (solid.low + solid.high) - 0.5 * brick * wanted + Vec3::Constant(0.5 * h);
  const auto size = static_cast<std::size_t>(entries);
  grid.slots_.assign(size, -1);
  grid.centers_.resize(size);
}

/// Chooses the bricks that touch the band around the surface.
template <class Real>
void DistanceGrid<Real>::Builder::choose(std::size_t max_bytes) {
  // Each thread processes one plane of bricks at a time.
  const auto plane =
      static_cast<std::size_t>(grid.count_.x()) * static_cast<std::size_t>(grid.count_.y());
  parallel_for(static_cast<std::size_t>(grid.count_.z()), [&](std::size_t z) {
    for (std::size_t at = z * plane; at < (z + 1) * plane; ++at) {
      check_cancelled();
      grid.centers_[at] = static_cast<Real>(solid.distance(grid.center_of(brick_of(at))));
    }
  });
  const double reach = grid.band_ + kBrickReach * grid.h_;
  for (std::size_t at = 0; at < grid.slots_.size(); ++at) {
    if (std::abs(static_cast<double>(grid.centers_[at])) > reach) continue;
    grid.slots_[at] = static_cast<std::int32_t>(bricks.size());
    bricks.push_back(brick_of(at));
  }
  const double bytes = static_cast<double>(bricks.size()) * kStored * sizeof(Real) +
                       static_cast<double>(grid.bytes());
  const auto limit = static_cast<double>(max_bytes);
  if (bytes > limit)
    throw std::invalid_argument(
        "resolution: " + text(grid.h_) + " m takes " + text(std::ceil(bytes / (1 << 20))) +
        " MiB, more than the limit of " + text(limit / (1 << 20)) +
        " MiB; give a larger one, about " + text(1.1 * grid.h_ * std::sqrt(bytes / limit)) +
        ", or a thinner band");
}

template <class Real>
void DistanceGrid<Real>::Builder::sample(std::size_t slot) {
  const Index first = kBrick * bricks[slot];
  Real* out = &raw[slot * kOwn];
  for (int z = 0; z < kBrick; ++z)
    for (int y = 0; y < kBrick; ++y)
      for (int x = 0; x < kBrick; ++x) *out++ = static_cast<Real>(distance(first + Index(x, y, z)));
}

/// Returns a sample from the brick that stores it, or else from the solid.
template <class Real>
double DistanceGrid<Real>::Builder::known(const Index& sample) const {
  const Index brick = sample.unaryExpr([](int i) { return i >> kBrickShift; });
  if ((brick.array() >= 0).all() && (brick.array() < grid.count_.array()).all()) {
    const std::int32_t slot = grid.slots_[grid.brick_index(brick)];
    const Index own = sample - kBrick * brick;
    if (slot >= 0)
      return static_cast<double>(
          raw[static_cast<std::size_t>(slot) * kOwn +
              static_cast<std::size_t>((own.z() * kBrick + own.y()) * kBrick + own.x())]);
  }
  return distance(sample);
}

template <class Real>
void DistanceGrid<Real>::Builder::store(std::size_t slot) {
  const bool quadratic = grid.interpolation_ == Interpolation::quadratic;
  const Index first = kBrick * bricks[slot] - Index::Constant(2);
  Wide wide{};
  const auto at = [](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * kWide + static_cast<std::size_t>(y)) * kWide +
           static_cast<std::size_t>(x);
  };
  const auto outermost = [](int i) { return i == 0 || i == kWide - 1; };
  for (int z = 0; z < kWide; ++z)
    for (int y = 0; y < kWide; ++y)
      for (int x = 0; x < kWide; ++x) {
        // Only the spline needs the outer apron, and only the faces of the apron.
        const int outer = int{outermost(x)} + int{outermost(y)} + int{outermost(z)};
        if (outer == 0 || (outer == 1 && quadratic))
          wide[at(x, y, z)] = known(first + Index(x, y, z));
      }
  Real* out = &grid.values_[slot * kStored];
  for (int z = 1; z <= kRow; ++z)
    for (int y = 1; y <= kRow; ++y)
      for (int x = 1; x <= kRow; ++x) {
        double value = wide[at(x, y, z)];
        // Quasi-interpolation (de Boor & Fix 1973): with the coefficients c = f - (f'' h^2) / 8
        // along each axis, the quadratic spline is exact for quadratic functions.
        if (quadratic)
          value = 1.75 * value -
                  0.125 * (wide[at(x - 1, y, z)] + wide[at(x + 1, y, z)] + wide[at(x, y - 1, z)] +
                           wide[at(x, y + 1, z)] + wide[at(x, y, z - 1)] + wide[at(x, y, z + 1)]);
        *out++ = static_cast<Real>(value);
      }
}

template <class Real>
DistanceGrid<Real>::DistanceGrid(const Solid& solid, const GridOptions& options) {
  Builder build{*this, solid, {}, {}};
  build.place(options);
  build.choose(options.max_bytes);
  const std::size_t count = build.bricks.size();
  build.raw.resize(count * Builder::kOwn);
  parallel_for(count, [&](std::size_t slot) { build.sample(slot); });
  values_.resize(count * kStored + 1);  // The last row needs a readable fourth number too.
  parallel_for(count, [&](std::size_t slot) { build.store(slot); });
}

template <class Real>
std::size_t DistanceGrid<Real>::bytes() const {
  return sizeof *this + slots_.size() * sizeof slots_[0] + centers_.size() * sizeof(Real) +
         values_.size() * sizeof(Real);
}

template <class Real>
std::size_t DistanceGrid<Real>::brick_index(const Index& brick) const noexcept {
  const auto x = static_cast<std::size_t>(brick.x()), y = static_cast<std::size_t>(brick.y()),
             z = static_cast<std::size_t>(brick.z());
  const auto nx = static_cast<std::size_t>(count_.x()), ny = static_cast<std::size_t>(count_.y());
  return (z * ny + y) * nx + x;
}

template <class Real>
Vec3 DistanceGrid<Real>::center_of(const Index& brick) const noexcept {
  constexpr double kMiddle = 0.5 * (kBrick - 1);
  return origin_ + h_ * (kBrick * brick.cast<double>() + Vec3::Constant(kMiddle));
}

template <class Real>
bool DistanceGrid<Real>::find(const Vec3& position, Place& place) const noexcept {
  // Add half a step, so that the integer part is the index of the nearest sample.
  const Vec3 u = inverse_h_ * (position - origin_) + Vec3::Constant(0.5);
  const bool in = u.x() >= 0.0 && u.y() >= 0.0 && u.z() >= 0.0 && u.x() < kBrick * count_.x() &&
                  u.y() < kBrick * count_.y() && u.z() < kBrick * count_.z();
  if (!in) return false;  // This is also the result for NaN.
  place.nearest = u.cast<int>();
  place.brick = Index(place.nearest.x() >> kBrickShift, place.nearest.y() >> kBrickShift,
                      place.nearest.z() >> kBrickShift);
  place.beyond = u - Vec3::Constant(0.5) - place.nearest.template cast<double>();
  place.at = brick_index(place.brick);
  return true;
}

template <class Real>
FieldPoint DistanceGrid<Real>::fine(const Place& place, std::int32_t slot) const noexcept {
  const Index own(place.nearest.x() & kBrickMask, place.nearest.y() & kBrickMask,
                  place.nearest.z() & kBrickMask);
  std::array<Weights<Real>, 3> w;
  for (std::size_t axis = 0; axis < w.size(); ++axis)
    w[axis] =
        weights(interpolation_, static_cast<Real>(place.beyond[static_cast<Eigen::Index>(axis)]));
  const Real* first =
      &values_[static_cast<std::size_t>(slot) * kStored +
               static_cast<std::size_t>((own.z() * kRow + own.y()) * kRow + own.x())];
  FieldPoint point = evaluate<Real>(first, kRow, kRow * kRow, w);
  point.gradient *= inverse_h_;
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
        around[n++] = centers_[brick_index(brick.cwiseMax(0).cwiseMin(count_ - Index::Ones()))];
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
  point.gradient *= inverse_h_ / kBrick;
  // In a brick without samples, every point is farther from the surface than the band.
  point.distance =
      centers_[place.at] > 0 ? std::max(point.distance, band_) : std::min(point.distance, -band_);
  return point;
}

template <class Real>
FieldPoint DistanceGrid<Real>::at(const Vec3& position) const noexcept {
  Place place;
  if (find(position, place)) [[likely]] {
    const std::int32_t slot = slots_[place.at];
    return slot >= 0 ? fine(place, slot) : coarse(place);
  }
  if (!position.allFinite()) return {std::numeric_limits<double>::quiet_NaN(), Vec3::Zero()};
  const Vec3 way = position - position.cwiseMax(low_).cwiseMin(high_);
  const Polar<double> out = polar(way);
  return {out.length, out.direction};
}

template <class Real>
double DistanceGrid<Real>::at_least(const Vec3& position, double sign,
                                    double wanted) const noexcept {
  Place place;
  if (!find(position, place)) {
    const double out = length(position - position.cwiseMax(low_).cwiseMin(high_));
    return sign > 0.0 && std::isfinite(out) ? out : -std::numeric_limits<double>::infinity();
  }
  const double quick =
      sign * static_cast<double>(centers_[place.at]) - (position - center_of(place.brick)).norm();
  const std::int32_t slot = slots_[place.at];
  if (quick > wanted || slot < 0) return quick;
  // The interpolation error is less than a grid step, at the sharpest edges of the solid.
  return std::max(quick, sign * fine(place, slot).distance - h_);
}

template class DistanceGrid<float>;
template class DistanceGrid<double>;

}  // namespace feltwire
