#pragma once
// The samples of a signed distance, in bricks of 8 x 8 x 8. Only the bricks near the surface are
// kept; every other brick has one value, the distance at its centre. A brick repeats the samples
// around it (its apron), so that a query reads only one brick.

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

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
  std::size_t max_bytes = std::size_t{1} << 30;  // a larger grid is refused (GridTooLarge)
};

/// The grid would take more memory than GridOptions::max_bytes.
class GridTooLarge : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The grid of a solid; its numbers are of type Real.
template <class Real>
struct BrickSamples {
  static constexpr int kShift = 3;            // a sample's index >> kShift is that of its brick
  static constexpr int kBrick = 1 << kShift;  // samples along an edge of a brick
  static constexpr int kRow = kBrick + 2;     // with the apron
  static constexpr std::size_t kStored = std::size_t{kRow} * kRow * kRow;
  using Index = Eigen::Vector3i;

  double h = 0.0, inverse_h = 0.0, band = 0.0;  // [m], [1/m], [m]
  Interpolation interpolation{};
  Vec3 low, high;                   // [m] of the solid
  Vec3 origin;                      // [m] of sample 0, 0, 0
  Index count = Index::Zero();      // bricks along x, y, z
  std::vector<std::int32_t> slots;  // of each brick, x fastest: the place of its samples, or -1
  std::vector<Real> centers;        // [m] signed distance at each brick's centre
  std::vector<Real> values;         // [m] samples or coefficients, x fastest, brick by brick

  std::size_t bytes() const {
    return sizeof *this + slots.size() * sizeof slots[0] + centers.size() * sizeof(Real) +
           values.size() * sizeof(Real);
  }
  /// The place of a brick in `slots` and `centers`.
  std::size_t brick_index(const Index& brick) const noexcept {
    const auto x = static_cast<std::size_t>(brick.x()), y = static_cast<std::size_t>(brick.y()),
               z = static_cast<std::size_t>(brick.z());
    const auto nx = static_cast<std::size_t>(count.x()), ny = static_cast<std::size_t>(count.y());
    return (z * ny + y) * nx + x;
  }
  /// [m] The centre of a brick.
  Vec3 center_of(const Index& brick) const noexcept {
    constexpr double kMiddle = 0.5 * (kBrick - 1);
    return origin + h * (kBrick * brick.cast<double>() + Vec3::Constant(kMiddle));
  }
};

/// Samples the solid, on all cores; the same bits on any number of them. `values` has a readable
/// number after the last sample. Throws std::invalid_argument that names resolution, value and
/// remedy if the options or the solid's box are not possible or the grid would be too large.
/// Precondition: Real is float or double.
template <class Real>
BrickSamples<Real> sample_bricks(const Solid& solid, const GridOptions& options);

}  // namespace feltwire
