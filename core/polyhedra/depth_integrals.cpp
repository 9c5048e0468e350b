#include "core/polyhedra/depth_integrals.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "core/polyhedra/depth_cell.hpp"
#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {
namespace {

using Tag = ClippedPolyhedron::Tag;

/// The tag of a plane between two cells: this and the other's candidate.
constexpr Tag kRidge = 0x8000;
static_assert(kRidge > kMostDepthPlanes && kRidge + kMostDepthPlanes < ClippedPolyhedron::kOwn);

/// The faces to which depth is measured somewhere in a polyhedron, each plane once.
struct Candidates {
  using Numbers = std::array<double, kMostDepthPlanes>;
  std::array<std::uint32_t, kMostDepthPlanes> of;
  alignas(16) Numbers x;  // of the planes' normals
  alignas(16) Numbers y;
  alignas(16) Numbers z;
  alignas(16) Numbers offset;  // [m]
  alignas(16) Numbers least;   // [m] depth in the polyhedron
  std::size_t count = 0;

  void add(const DepthPlanes& planes, std::size_t i, double least_depth) {
    constexpr double kSame = 1e-12;
    const DepthPlane& plane = planes[i];
    for (std::size_t k = 0; k < count; ++k)
      if (std::abs(offset[k] - plane.offset) < kSame && (normal(k) - plane.normal).norm() < kSame)
        return;
    x[count] = plane.normal.x();
    y[count] = plane.normal.y();
    z[count] = plane.normal.z();
    offset[count] = plane.offset;
    least[count] = least_depth;
    of[count++] = static_cast<std::uint32_t>(i);
  }

  Vec3 normal(std::size_t k) const { return {x[k], y[k], z[k]}; }

  std::size_t nearest_to(const Vec3& p) const {
    alignas(16) Numbers depth;
    const auto all = [&](const Numbers& values) {
      return Eigen::Map<const Eigen::ArrayXd, Eigen::Aligned16>(values.data(),
                                                                static_cast<Eigen::Index>(count));
    };
    Eigen::Map<Eigen::ArrayXd, Eigen::Aligned16> depths(depth.data(),
                                                        static_cast<Eigen::Index>(count));
    depths = all(offset) - (all(x) * p.x() + all(y) * p.y() + all(z) * p.z());
    const double shortest = depths.minCoeff();
    std::size_t at = 0;
    while (at + 1 < count && depth[at] != shortest) ++at;
    return at;
  }
};

/// Which cells are known, and which of them lie beside others. Of the first candidates only: a set
/// is the bits of a number.
class KnownCells {
 public:
  /// Whether it is known if another lies beside a cell.
  bool is_settled(std::size_t cell, std::size_t other) const {
    return cell < kBits && other < kBits && (known_ >> other & 1) != 0;
  }
  /// Calls visit(other) for each known one beside a cell. False as soon as it returns false.
  template <class Visit>
  bool all_beside(std::size_t cell, const Visit& visit) const {
    if (cell >= kBits) return true;
    for (std::uint64_t left = beside_[cell] & known_; left != 0; left &= left - 1)
      if (!visit(static_cast<std::size_t>(std::countr_zero(left)))) return false;
    return true;
  }
  void add(std::size_t cell) {
    if (cell < kBits) known_ |= std::uint64_t{1} << cell;
  }
  /// A known cell and one beside it.
  void join(std::size_t cell, std::size_t other) {
    if (cell < kBits && other < kBits) beside_[other] |= std::uint64_t{1} << cell;
  }

 private:
  static constexpr std::size_t kBits = 64;
  std::uint64_t known_ = 0;
  std::array<std::uint64_t, kBits> beside_{};
};

/// Leaves of a polyhedron the part where candidate k is the nearest. First by the planes to cells
/// that lie beside it, then by that which is the nearest in the middle of what is left, so that
/// little is left for the others to look at.
bool cut_to_cell(ClippedPolyhedron& common, const Candidates& nearest, const KnownCells& known,
                 std::size_t k) {
  const Vec3 normal = nearest.normal(k);
  const auto cut = [&](std::size_t other) {
    return common.cut(nearest.normal(other) - normal, nearest.offset[other] - nearest.offset[k],
                      static_cast<Tag>(kRidge + other));
  };
  if (!known.all_beside(k, cut)) return false;
  for (std::size_t round = 0; round < nearest.count; ++round) {
    const std::size_t other = nearest.nearest_to(common.middle());
    if (other == k) break;
    if (!cut(other)) return false;
  }
  const double deepest = -common.extent(normal, nearest.offset[k]).least;
  const ClippedPolyhedron::Box box = common.box();
  for (std::size_t other = 0; other < nearest.count; ++other) {
    if (other == k || !(nearest.least[other] < deepest) || known.is_settled(k, other)) continue;
    // Nowhere in the box is the other nearer?
    const Vec3 across = nearest.normal(other) - normal;
    const double most = across.dot(box.middle) + across.cwiseAbs().dot(box.half);
    if (most > nearest.offset[other] - nearest.offset[k] && !cut(other)) return false;
  }
  return true;
}

/// Outside of a hollow the depth is that beyond the face which is farthest behind.
void add_hollow(const PlacedPart& tool, const ClippedPolyhedron& whole, const DepthPlanes& planes,
                bool slides, DepthSums& sums) {
  Candidates beyond;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (whole.extent(planes[i].normal, planes[i].offset).most > 0.0) beyond.add(planes, i, 0.0);
  for (std::size_t k = 0; k < beyond.count; ++k) {
    const DepthPlane& plane = planes[beyond.of[k]];
    ClippedPolyhedron common(whole);
    const auto own = static_cast<Tag>(beyond.of[k]);
    bool left = common.cut(-plane.normal, -plane.offset, own);
    for (std::size_t other = 0; left && other < beyond.count; ++other) {
      if (other == k) continue;
      const DepthPlane& nearer = planes[beyond.of[other]];
      left = common.cut(nearer.normal - plane.normal, nearer.offset - plane.offset, kRidge);
    }
    if (left)
      add_cell(common, Cell(plane.normal, -plane.offset, tool.origin), own, planes, slides, sums);
  }
}

}  // namespace

void add_depth(const PlacedPart& tool, const SolidPart& solid, bool hollow, const Vec3* away,
               bool slides, DepthSums& sums) noexcept {
  const DepthPlanes planes(solid, away);
  ClippedPolyhedron inside;
  inside.assign(tool.shape, tool.rotation, tool.origin);
  if (hollow) {
    add_hollow(tool, inside, planes, slides, sums);
    return;
  }
  const auto cut = [&](std::size_t i) {
    return inside.cut(planes[i].normal, planes[i].offset, static_cast<Tag>(i));
  };
  if (!cut(planes.facing())) return;
  std::array<double, kMostDepthPlanes> least;  // [m] depth, at first a lower bound of it
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const ClippedPolyhedron::Extent above = inside.extent(planes[i].normal, planes[i].offset);
    least[i] = -above.most;
    if (above.most > 0.0 && !cut(i)) return;
  }
  // A face can be the nearest somewhere only if it is nearer there than some other is everywhere.
  // That which faces the tool mostly is.
  double bound = std::numeric_limits<double>::infinity();
  const DepthPlane& facing = planes[planes.facing()];
  if (!facing.inner) bound = -inside.extent(facing.normal, facing.offset).least;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].inner || !(least[i] < bound)) continue;
    const ClippedPolyhedron::Extent above = inside.extent(planes[i].normal, planes[i].offset);
    least[i] = -above.most;
    bound = std::min(bound, -above.least);
  }
  Candidates nearest;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (!planes[i].inner && least[i] < bound) nearest.add(planes, i, least[i]);
  if (nearest.count == 0) return;
  // From the cell in the middle to those beside it. As the depth is concave, the cells are convex,
  // and one reaches all of them over ridges.
  std::array<std::uint32_t, kMostDepthPlanes> waiting;
  std::array<std::uint8_t, kMostDepthPlanes> is_known;
  std::fill_n(is_known.begin(), nearest.count, std::uint8_t{0});
  std::size_t next = 0, count = 0;
  const auto look_at = [&](std::size_t k) {
    if (is_known[k] != 0) return;
    is_known[k] = 1;
    waiting[count++] = static_cast<std::uint32_t>(k);
  };
  KnownCells known;
  look_at(nearest.nearest_to(inside.middle()));
  while (next < count) {
    const std::size_t k = waiting[next++];
    const DepthPlane& plane = planes[nearest.of[k]];
    ClippedPolyhedron common(inside);
    known.add(k);
    if (!cut_to_cell(common, nearest, known, k)) continue;
    add_cell(common, Cell(-plane.normal, plane.offset, tool.origin),
             static_cast<Tag>(nearest.of[k]), planes, slides, sums);
    for (std::size_t i = 0; i < common.corner_count(); ++i)
      for (const Tag tag : common.tags(i))
        if (tag >= kRidge && tag != ClippedPolyhedron::kOwn) {
          look_at(tag - kRidge);
          known.join(k, tag - kRidge);
        }
  }
}

}  // namespace feltwire
