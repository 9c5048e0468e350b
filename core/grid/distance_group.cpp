#include "core/grid/distance_group.hpp"

#include <array>
#include <cstring>

// A place reads nine rows of samples. The rows of four places are transposed, so that each lane of
// a vector belongs to one place and all arithmetic is vector arithmetic. The width is fixed here
// and not chosen by the compiler: every machine gives the same bits.

namespace feltwire {
namespace {

constexpr std::size_t kQuad = 4;
constexpr std::size_t kTaps = 3;  // samples along an axis

/// Four numbers, one for each place.
template <class Real>
struct Quad {
  typedef Real Type __attribute__((vector_size(kQuad * sizeof(Real))));
};

template <class Type, class Real>
void load(Type& quad, const Real* from) noexcept {
  std::memcpy(&quad, from, sizeof quad);
}

/// Weights of the samples before, at and after the nearest sample along an axis, and their
/// derivatives. They equal the weights for a single place (distance_grid.cpp).
template <class Type>
struct QuadWeights {
  std::array<Type, kTaps> value, slope;
};

template <class Real, class Type>
void weigh(Interpolation interpolation, const Real* beyond, QuadWeights<Type>& w) noexcept {
  Type t;
  load(t, beyond);
  const Real half(0.5);
  if (interpolation == Interpolation::quadratic) {
    const Type before = half - t, after = half + t;
    w.value = {half * before * before, Real(0.75) - t * t, half * after * after};
    w.slope = {-before, -2 * t, after};
    return;
  }
  const Type zero = t - t, one = zero + 1;
  const Type below = t < zero ? one : zero, above = one - below;
  w.value = {-t * below, one + t * (below - above), t * above};
  w.slope = {-below, below - above, above};
}

using Offsets = std::array<std::size_t, FieldGroup::kSize>;  // of the first sample, into `values`
/// [h] The places less their nearest samples, along x, y and z.
template <class Real>
using Beyond = std::array<std::array<Real, FieldGroup::kSize>, 3>;

/// Finds the samples of all places. Returns false if a place is too far from the surface to have
/// samples.
template <class Real>
bool find(const BrickSamples<Real>& grid, const FieldGroup& group, Offsets& offsets,
          Beyond<Real>& beyond) noexcept {
  using Lanes = FieldGroup::Lanes;
  constexpr int kBrick = BrickSamples<Real>::kBrick, kRow = BrickSamples<Real>::kRow;
  // Add half a step, so that the integer part is the index of the nearest sample.
  const std::array<Lanes, 3> u = {grid.inverse_h * (group.x - grid.origin.x()) + 0.5,
                                  grid.inverse_h * (group.y - grid.origin.y()) + 0.5,
                                  grid.inverse_h * (group.z - grid.origin.z()) + 0.5};
  std::array<std::array<std::uint32_t, FieldGroup::kSize>, 3> nearest;
  for (std::size_t axis = 0; axis < u.size(); ++axis) {
    const double end = kBrick * grid.count[static_cast<Eigen::Index>(axis)];
    if (!(u[axis].minCoeff() >= 0.0 && u[axis].maxCoeff() < end) || !u[axis].allFinite())
      return false;
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
      const double at = u[axis][static_cast<Eigen::Index>(lane)];
      const int index = static_cast<int>(at);
      nearest[axis][lane] = static_cast<std::uint32_t>(index);
      beyond[axis][lane] = static_cast<Real>(at - 0.5 - index);
    }
  }
  for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
    const std::uint32_t x = nearest[0][lane], y = nearest[1][lane], z = nearest[2][lane];
    const auto nx = static_cast<std::size_t>(grid.count.x()),
               ny = static_cast<std::size_t>(grid.count.y());
    const std::int32_t slot = grid.slots[(z / kBrick * ny + y / kBrick) * nx + x / kBrick];
    if (slot < 0) return false;
    const std::size_t own = (std::size_t{z % kBrick} * kRow + y % kBrick) * kRow + x % kBrick;
    offsets[lane] = static_cast<std::size_t>(slot) * BrickSamples<Real>::kStored + own;
  }
  return true;
}

template <class Real>
void evaluate(const BrickSamples<Real>& grid, const Offsets& offsets, const Beyond<Real>& beyond,
              FieldGroup& group) noexcept {
  constexpr int kRow = BrickSamples<Real>::kRow;
  using Four = typename Quad<Real>::Type;
  for (std::size_t half = 0; half < FieldGroup::kSize; half += kQuad) {
    std::array<QuadWeights<Four>, 3> w;
    for (std::size_t axis = 0; axis < w.size(); ++axis)
      weigh<Real>(grid.interpolation, &beyond[axis][half], w[axis]);
    const Four zero = w[0].value[0] - w[0].value[0];
    Four value = zero, slope_x = zero, slope_y = zero, slope_z = zero;
    for (std::size_t z = 0; z < kTaps; ++z) {
      Four layer = zero, layer_x = zero, layer_y = zero;
      for (std::size_t y = 0; y < kTaps; ++y) {
        const std::size_t row = (z * kRow + y) * kRow;
        std::array<Four, kQuad> from;
        for (std::size_t i = 0; i < kQuad; ++i)
          load(from[i],
               &grid.values[offsets[half + i] + row]);  // the fourth number has weight zero
        const Four low = __builtin_shufflevector(from[0], from[1], 0, 4, 1, 5);
        const Four high = __builtin_shufflevector(from[2], from[3], 0, 4, 1, 5);
        const Four low_last = __builtin_shufflevector(from[0], from[1], 2, 6, 3, 7);
        const Four high_last = __builtin_shufflevector(from[2], from[3], 2, 6, 3, 7);
        const Four before = __builtin_shufflevector(low, high, 0, 1, 4, 5);
        const Four at = __builtin_shufflevector(low, high, 2, 3, 6, 7);
        const Four after = __builtin_shufflevector(low_last, high_last, 0, 1, 4, 5);
        const Four along = w[0].value[0] * before + w[0].value[1] * at + w[0].value[2] * after;
        layer += w[1].value[y] * along;
        layer_y += w[1].slope[y] * along;
        layer_x +=
            w[1].value[y] * (w[0].slope[0] * before + w[0].slope[1] * at + w[0].slope[2] * after);
      }
      value += w[2].value[z] * layer;
      slope_x += w[2].value[z] * layer_x;
      slope_y += w[2].value[z] * layer_y;
      slope_z += w[2].slope[z] * layer;
    }
    for (std::size_t i = 0; i < kQuad; ++i) {
      const auto lane = static_cast<Eigen::Index>(half + i);
      group.distance[lane] = static_cast<double>(value[i]);
      group.gradient_x[lane] = static_cast<double>(slope_x[i]);
      group.gradient_y[lane] = static_cast<double>(slope_y[i]);
      group.gradient_z[lane] = static_cast<double>(slope_z[i]);
    }
  }
  group.gradient_x *= grid.inverse_h;
  group.gradient_y *= grid.inverse_h;
  group.gradient_z *= grid.inverse_h;
}

}  // namespace

template <class Real>
bool evaluate_group(const BrickSamples<Real>& grid, FieldGroup& group) noexcept {
  Offsets offsets;
  Beyond<Real> beyond;
  if (!find(grid, group, offsets, beyond)) return false;
  evaluate(grid, offsets, beyond, group);
  return true;
}

template bool evaluate_group(const BrickSamples<float>&, FieldGroup&) noexcept;
template bool evaluate_group(const BrickSamples<double>&, FieldGroup&) noexcept;

}  // namespace feltwire
