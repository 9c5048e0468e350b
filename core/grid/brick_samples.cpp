#include "core/grid/brick_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/base/parallel.hpp"
#include "core/base/written_number.hpp"

namespace feltwire {
namespace {

constexpr double kMaxBricksAlong = 1 << 20;  // Every index fits an int.
/// Half the diagonal of a brick's cells, in grid steps. No point of a brick is farther from its
/// centre.
const double kBrickReach = 4.0 * std::sqrt(3.0);

/// Computes the samples of a solid.
template <class Real>
struct BrickSampler {
  using Samples = BrickSamples<Real>;
  using Index = Eigen::Vector3i;
  static constexpr int kBrick = Samples::kBrick, kRow = Samples::kRow;

  Samples& grid;
  const Solid& solid;
  std::vector<Index> bricks;  // bricks with samples, in table order
  std::vector<Real> raw;      // samples of these bricks, without aprons (borders)

  static constexpr std::size_t kOwn = std::size_t{kBrick} * kBrick * kBrick;
  static constexpr int kWide = kBrick + 4;  // brick with an apron of two samples
  using Wide = std::array<double, std::size_t{kWide} * kWide * kWide>;

  double distance(const Index& sample) const {
    return solid.distance(grid.origin + grid.h * sample.cast<double>());
  }
  Index brick_of(std::size_t at) const {
    const auto nx = static_cast<std::size_t>(grid.count.x()),
               ny = static_cast<std::size_t>(grid.count.y());
    return {static_cast<int>(at % nx), static_cast<int>(at / nx % ny),
            static_cast<int>(at / nx / ny)};
  }

  void fill(const GridOptions& options);
  void place(const GridOptions& options);
  void choose(std::size_t max_bytes);
  void sample(std::size_t slot);
  double known(const Index& sample) const;
  void store(std::size_t slot);
};

template <class Real>
void BrickSampler<Real>::fill(const GridOptions& options) {
  place(options);
  choose(options.max_bytes);
  const std::size_t count = bricks.size();
  raw.resize(count * kOwn);
  parallel_for(count, [&](std::size_t slot) { sample(slot); });
  grid.values.resize(count * Samples::kStored + 1);  // the last row needs a fourth number, too
  parallel_for(count, [&](std::size_t slot) { store(slot); });
}

/// Determines the extent and the table of the grid.
template <class Real>
void BrickSampler<Real>::place(const GridOptions& options) {
  const double h = options.resolution;
  if (!(h > 0.0) || !std::isfinite(h))
    throw std::invalid_argument("resolution: must be above zero [m], is " + shortest_text(h) +
                                "; give the distance between samples");
  if (!(options.band >= 0.0) || !std::isfinite(options.band))
    throw std::invalid_argument("band: must be at least zero [m], is " +
                                shortest_text(options.band) + "; leave it out or give a depth");
  const Vec3 extent = solid.high - solid.low;
  if (!extent.allFinite() || !(extent.minCoeff() >= 0.0))
    throw std::invalid_argument(
        "the solid has no extent that could be sampled; give one that is bounded");
  grid.h = h;
  grid.inverse_h = 1.0 / h;
  grid.band = std::max(options.band, kBrick * h);
  grid.interpolation = options.interpolation;
  grid.low = solid.low;
  grid.high = solid.high;

  const double brick = kBrick * h;
  const Vec3 wanted = ((extent.array() + 2.0 * (grid.band + h)) / brick).ceil();
  const double entries = wanted.prod();
  const double bytes = entries * (sizeof(std::int32_t) + sizeof(Real));
  const auto limit = static_cast<double>(options.max_bytes);
  if (!(wanted.maxCoeff() < kMaxBricksAlong) || !(bytes < limit))
    throw GridTooLarge("resolution: " + shortest_text(h) + " m over an extent of " +
                       shortest_text(extent.maxCoeff()) + " m takes more than the limit of " +
                       shortest_text(limit / (1 << 20)) + " MiB; give a larger one, at least " +
                       shortest_text(h * std::max(1.5 * std::cbrt(bytes / limit),
                                                  wanted.maxCoeff() / kMaxBricksAlong)));
  grid.count = wanted.cast<int>();
  grid.origin = 0.5 * (solid.low + solid.high) - 0.5 * brick * wanted + Vec3::Constant(0.5 * h);
  const auto size = static_cast<std::size_t>(entries);
  grid.slots.assign(size, -1);
  grid.centers.resize(size);
}

/// Chooses the bricks that touch the band around the surface.
template <class Real>
void BrickSampler<Real>::choose(std::size_t max_bytes) {
  // Each thread processes one plane of bricks at a time.
  const auto plane =
      static_cast<std::size_t>(grid.count.x()) * static_cast<std::size_t>(grid.count.y());
  parallel_for(static_cast<std::size_t>(grid.count.z()), [&](std::size_t z) {
    for (std::size_t at = z * plane; at < (z + 1) * plane; ++at) {
      check_cancelled();
      grid.centers[at] = static_cast<Real>(solid.distance(grid.center_of(brick_of(at))));
    }
  });
  const double reach = grid.band + kBrickReach * grid.h;
  for (std::size_t at = 0; at < grid.slots.size(); ++at) {
    if (std::abs(static_cast<double>(grid.centers[at])) > reach) continue;
    grid.slots[at] = static_cast<std::int32_t>(bricks.size());
    bricks.push_back(brick_of(at));
  }
  const double bytes = static_cast<double>(bricks.size()) * Samples::kStored * sizeof(Real) +
                       static_cast<double>(grid.bytes());
  const auto limit = static_cast<double>(max_bytes);
  if (bytes > limit)
    throw GridTooLarge(
        "resolution: " + shortest_text(grid.h) + " m takes " +
        shortest_text(std::ceil(bytes / (1 << 20))) + " MiB, more than the limit of " +
        shortest_text(limit / (1 << 20)) + " MiB; give a larger one, about " +
        shortest_text(1.1 * grid.h * std::sqrt(bytes / limit)) + ", or a thinner band");
}

template <class Real>
void BrickSampler<Real>::sample(std::size_t slot) {
  const Index first = kBrick * bricks[slot];
  Real* out = &raw[slot * kOwn];
  for (int z = 0; z < kBrick; ++z)
    for (int y = 0; y < kBrick; ++y)
      for (int x = 0; x < kBrick; ++x) *out++ = static_cast<Real>(distance(first + Index(x, y, z)));
}

/// Returns a sample from the brick that stores it, or else from the solid.
template <class Real>
double BrickSampler<Real>::known(const Index& sample) const {
  const Index brick = sample.unaryExpr([](int i) { return i >> Samples::kShift; });
  if ((brick.array() >= 0).all() && (brick.array() < grid.count.array()).all()) {
    const std::int32_t slot = grid.slots[grid.brick_index(brick)];
    const Index own = sample - kBrick * brick;
    if (slot >= 0)
      return static_cast<double>(
          raw[static_cast<std::size_t>(slot) * kOwn +
              static_cast<std::size_t>((own.z() * kBrick + own.y()) * kBrick + own.x())]);
  }
  return distance(sample);
}

template <class Real>
void BrickSampler<Real>::store(std::size_t slot) {
  const bool quadratic = grid.interpolation == Interpolation::quadratic;
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
  Real* out = &grid.values[slot * Samples::kStored];
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

}  // namespace

template <class Real>
BrickSamples<Real> sample_bricks(const Solid& solid, const GridOptions& options) {
  BrickSamples<Real> grid;
  BrickSampler<Real>{grid, solid, {}, {}}.fill(options);
  return grid;
}

template BrickSamples<float> sample_bricks<float>(const Solid&, const GridOptions&);
template BrickSamples<double> sample_bricks<double>(const Solid&, const GridOptions&);

}  // namespace feltwire
