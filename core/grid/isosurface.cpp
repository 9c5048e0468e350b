#include "core/grid/isosurface.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace feltwire {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// Values of the distance field at the corners of cubic cells.
class Lattice {
 public:
  Lattice(const DistanceGrid<float>& grid, int steps) {
    const Vec3 size = grid.high() - grid.low();
    step_ = size.maxCoeff() / steps;
    // Leave more than a cell on each side, so that the surface is closed. Avoid a whole number of
    // cells: otherwise a flat side of the solid lies in a plane of corners, and cells share their
    // vertices.
    constexpr double kAside = 1.63;  // number of cells between the solid and the border
    origin_ = grid.low() - Vec3::Constant(kAside * step_);
    for (int axis = 0; axis < 3; ++axis)
      count_[static_cast<std::size_t>(axis)] =
          static_cast<std::size_t>(std::ceil(size[axis] / step_)) + 5;
    values_.reserve(count_[0] * count_[1] * count_[2]);
    for (std::size_t z = 0; z < count_[2]; ++z)
      for (std::size_t y = 0; y < count_[1]; ++y)
        for (std::size_t x = 0; x < count_[0]; ++x)
          values_.push_back(grid.at(place(x, y, z)).distance);
  }

  Vec3 place(std::size_t x, std::size_t y, std::size_t z) const {
    return origin_ +
           step_ * Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
  }
  std::size_t index(std::size_t x, std::size_t y, std::size_t z) const {
    return (z * count_[1] + y) * count_[0] + x;
  }
  double value(std::size_t x, std::size_t y, std::size_t z) const {
    return values_[index(x, y, z)];
  }
  std::size_t size() const { return values_.size(); }
  const std::array<std::size_t, 3>& count() const { return count_; }

  /// Returns the mean of the points where the surface crosses the edges of a cell. Returns nothing
  /// if the surface crosses no edge.
  std::optional<Vec3> crossing(std::size_t x, std::size_t y, std::size_t z) const {
    Vec3 sum = Vec3::Zero();
    int crossed = 0;
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        if ((corner >> axis & 1) != 0) continue;
        const std::array<std::size_t, 3> a = {x + static_cast<std::size_t>(corner & 1),
                                              y + static_cast<std::size_t>(corner >> 1 & 1),
                                              z + static_cast<std::size_t>(corner >> 2 & 1)};
        std::array<std::size_t, 3> b = a;
        ++b[static_cast<std::size_t>(axis)];
        const double at_a = value(a[0], a[1], a[2]), at_b = value(b[0], b[1], b[2]);
        if ((at_a < 0.0) == (at_b < 0.0)) continue;
        const double share = at_a / (at_a - at_b);
        sum += (1.0 - share) * place(a[0], a[1], a[2]) + share * place(b[0], b[1], b[2]);
        ++crossed;
      }
    if (crossed == 0) return std::nullopt;
    return Vec3(sum / crossed);
  }

 private:
  double step_ = 0.0;
  Vec3 origin_ = Vec3::Zero();
  std::array<std::size_t, 3> count_{};
  std::vector<double> values_;
};

}  // namespace

TriangleSoup isosurface(const DistanceGrid<float>& grid, int steps) {
  constexpr int kFewest = 2, kMost = 256;
  if (steps < kFewest || steps > kMost)
    throw std::invalid_argument("steps: is " + std::to_string(steps) + "; use 2 to 256");
  const Lattice lattice(grid, steps);
  const auto& [nx, ny, nz] = lattice.count();
  TriangleSoup soup;
  std::vector<std::uint32_t> vertex(lattice.size(), kNoVertex);
  for (std::size_t z = 0; z + 1 < nz; ++z)
    for (std::size_t y = 0; y + 1 < ny; ++y)
      for (std::size_t x = 0; x + 1 < nx; ++x)
        if (const auto place = lattice.crossing(x, y, z)) {
          vertex[lattice.index(x, y, z)] = static_cast<std::uint32_t>(soup.vertices.size());
          soup.vertices.push_back(*place);
        }

  // Four cells surround an edge that the surface crosses. Their vertices form a square.
  const auto join = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d, bool outwards) {
    const std::array<std::uint32_t, 4> corner = {vertex[a], vertex[b], vertex[c], vertex[d]};
    if (outwards) {
      soup.triangles.push_back({corner[0], corner[1], corner[2]});
      soup.triangles.push_back({corner[0], corner[2], corner[3]});
    } else {
      soup.triangles.push_back({corner[0], corner[2], corner[1]});
      soup.triangles.push_back({corner[0], corner[3], corner[2]});
    }
  };
  for (std::size_t z = 1; z + 1 < nz; ++z)
    for (std::size_t y = 1; y + 1 < ny; ++y)
      for (std::size_t x = 1; x + 1 < nx; ++x) {
        const bool inside = lattice.value(x, y, z) < 0.0;
        const auto at = [&](std::size_t i, std::size_t j, std::size_t k) {
          return lattice.index(i, j, k);
        };
        if (inside != (lattice.value(x + 1, y, z) < 0.0))
          join(at(x, y - 1, z - 1), at(x, y, z - 1), at(x, y, z), at(x, y - 1, z), inside);
        if (inside != (lattice.value(x, y + 1, z) < 0.0))
          join(at(x - 1, y, z - 1), at(x - 1, y, z), at(x, y, z), at(x, y, z - 1), inside);
        if (inside != (lattice.value(x, y, z + 1) < 0.0))
          join(at(x - 1, y - 1, z), at(x, y - 1, z), at(x, y, z), at(x - 1, y, z), inside);
      }
  return soup;
}

}  // namespace feltwire
