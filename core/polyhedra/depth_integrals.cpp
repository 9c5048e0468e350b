#include "core/polyhedra/depth_integrals.hpp"

#include <algorithm>
#include <limits>

#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {
namespace {

/// The tag of a plane between two cells: this and the other's candidate.
constexpr std::uint32_t kRidge = 0x10000;
static_assert(kRidge > kMostDepthPlanes && kRidge + kMostDepthPlanes < ClippedPolyhedron::kOwn);

/// The rule of six points for polynomials of degree four on a triangle (Strang & Fix 1973): weights
/// of its area, and places by their weights on the corners.
struct TrianglePoint {
  double weight;
  std::array<double, 3> at;
};
constexpr double kInnerWeight = 0.22338158967801146570, kInner = 0.44594849091596488632;
constexpr double kOuterWeight = 0.10995174365532186764, kOuter = 0.091576213509770743460;
constexpr std::array<TrianglePoint, 6> kRule = {
    {{kInnerWeight, {kInner, kInner, 1.0 - 2.0 * kInner}},
     {kInnerWeight, {kInner, 1.0 - 2.0 * kInner, kInner}},
     {kInnerWeight, {1.0 - 2.0 * kInner, kInner, kInner}},
     {kOuterWeight, {kOuter, kOuter, 1.0 - 2.0 * kOuter}},
     {kOuterWeight, {kOuter, 1.0 - 2.0 * kOuter, kOuter}},
     {kOuterWeight, {1.0 - 2.0 * kOuter, kOuter, kOuter}}}};

/// The part of space where one face is that to which depth is measured: d = inwards . x + constant.
struct Cell {
  Vec3 inwards, across, along;  // a right-handed frame: (across, along, inwards)
  double constant;              // [m]
  Vec3 origin;                  // [m] of the tool

  Cell(const Vec3& inwards_of, double constant_of, const Vec3& origin_of)
      : inwards(inwards_of), constant(constant_of), origin(origin_of) {
    across = inwards.unitOrthogonal();
    along = inwards.cross(across);
  }
  /// (u, v, d): two coordinates from the tool's origin along the face, and the depth.
  Vec3 seen(const Vec3& x) const {
    const Vec3 arm = x - origin;
    return {across.dot(arm), along.dot(arm), inwards.dot(x) + constant};
  }
};

/// Integrals over what a cell and the tool's part have in common. By Gauss that of f(u, v) d^n is
/// that of f d^(n + 1) / (n + 1) over the surface, projected on the face.
struct Moments {
  double cubes = 0.0;               // of d^3
  std::array<double, 3> squares{};  // of d^2 (1, u, v)
  std::array<double, 6> depths{};   // of d (1, u, v, u u, u v, v v)

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double area =
        0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
    if (area == 0.0) return;
    for (const TrianglePoint& point : kRule) {
      const double u = point.at[0] * a.x() + point.at[1] * b.x() + point.at[2] * c.x();
      const double v = point.at[0] * a.y() + point.at[1] * b.y() + point.at[2] * c.y();
      const double d = point.at[0] * a.z() + point.at[1] * b.z() + point.at[2] * c.z();
      const double first = point.weight * area * d * d / 2.0, second = first * d * 2.0 / 3.0;
      cubes += second * d * 3.0 / 4.0;
      squares[0] += second;
      squares[1] += second * u;
      squares[2] += second * v;
      depths[0] += first;
      depths[1] += first * u;
      depths[2] += first * v;
      depths[3] += first * u * u;
      depths[4] += first * u * v;
      depths[5] += first * v * v;
    }
  }
};

std::size_t side_of(const Vec3& way) {
  Eigen::Index axis;
  way.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::size_t>(axis) + (way[axis] < 0.0 ? 1 : 0);
}

/// A motion (t, w) of the tool moves the point at (u, v) out of the solid by (W_0 + v W_1 + u W_2)
/// . (t, w).
struct Ways {
  Vec6 translation, about_across, about_along;

  explicit Ways(const Cell& cell) {
    translation << -cell.inwards, Vec3::Zero();
    about_across << Vec3::Zero(), -cell.across;
    about_along << Vec3::Zero(), cell.along;
  }
};

void add_slip(const Cell& cell, const Moments& m, DepthSums& sums) {
  const double weight = m.squares[0];
  const double u = m.squares[1] / weight, v = m.squares[2] / weight;
  const double d = m.cubes / weight - cell.constant - cell.inwards.dot(cell.origin);
  const Vec3 centre = u * cell.across + v * cell.along + d * cell.inwards;
  // The spread along the face, by the depth.
  const double mean_u = m.depths[1] / m.depths[0], mean_v = m.depths[2] / m.depths[0];
  const double uu = m.depths[3] / m.depths[0] - mean_u * mean_u;
  const double uv = m.depths[4] / m.depths[0] - mean_u * mean_v;
  const double vv = m.depths[5] / m.depths[0] - mean_v * mean_v;
  SlipSums& side = sums.sides[side_of(-cell.inwards)];
  side.add(weight, centre, -cell.inwards);
  side.arms +=
      weight * (uu * cell.across * cell.across.transpose() +
                uv * (cell.across * cell.along.transpose() + cell.along * cell.across.transpose()) +
                vv * cell.along * cell.along.transpose());
}

/// Of a face at which the part ends inside the solid.
void add_inner_face(const ClippedPolyhedron& common, const ClippedPolyhedron::Face& face,
                    const Cell& cell, Vec6& slope) {
  const auto edges = common.edges(face);
  const Vec3& a = common.vertices()[edges.front().from];
  for (const auto& edge : edges.subspan(1)) {
    const Vec3 &b = common.vertices()[edge.from], &c = common.vertices()[edge.to];
    const Vec3 area = 0.5 * (b - a).cross(c - a);
    double cubes = 0.0;
    Vec3 arm = Vec3::Zero();
    for (const TrianglePoint& point : kRule) {
      const Vec3 x = point.at[0] * a + point.at[1] * b + point.at[2] * c;
      const double d = cell.inwards.dot(x) + cell.constant;
      cubes += point.weight * d * d * d;
      arm += point.weight * d * d * d * (x - cell.origin);
    }
    slope.head<3>() -= cubes * area;
    slope.tail<3>() -= arm.cross(area);
  }
}

void add_cell(const ClippedPolyhedron& common, const Cell& cell, const DepthPlanes& planes,
              bool slides, DepthSums& sums) {
  Moments m;
  std::array<Vec3, ClippedPolyhedron::kVertices> seen;
  for (std::size_t v = 0; v < common.vertices().size(); ++v)
    seen[v] = cell.seen(common.vertices()[v]);
  for (const auto& face : common.faces()) {
    const auto edges = common.edges(face);
    const Vec3& corner = seen[edges.front().from];
    for (const auto& edge : edges.subspan(1)) m.add(corner, seen[edge.from], seen[edge.to]);
  }
  if (!(m.cubes > 0.0 && m.squares[0] > 0.0 && m.depths[0] > 0.0)) return;
  for (const auto& face : common.faces())
    if (face.tag < planes.size() && planes[face.tag].inner)
      add_inner_face(common, face, cell, sums.slope);
  ++sums.cells;
  sums.cubes += m.cubes;
  const Ways w(cell);
  const Vec6 out = 3.0 * (m.squares[0] * w.translation + m.squares[2] * w.about_across +
                          m.squares[1] * w.about_along);
  sums.slope -= out;
  sums.pushed -= out;
  const Vec6 t =
      m.depths[0] * w.translation + m.depths[2] * w.about_across + m.depths[1] * w.about_along;
  const Vec6 a =
      m.depths[2] * w.translation + m.depths[5] * w.about_across + m.depths[4] * w.about_along;
  const Vec6 b =
      m.depths[1] * w.translation + m.depths[4] * w.about_across + m.depths[3] * w.about_along;
  sums.curvature += 6.0 * (w.translation * t.transpose() + w.about_across * a.transpose() +
                           w.about_along * b.transpose());
  if (slides) add_slip(cell, m, sums);
}

/// How deep the corners of a polyhedron lie below a plane.
struct Extent {
  double least, most;
};
Extent depth_extent(const ClippedPolyhedron& common, const DepthPlane& plane) {
  Extent extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Vec3& x : common.vertices()) {
    const double d = plane.offset - plane.normal.dot(x);
    extent.least = std::min(extent.least, d);
    extent.most = std::max(extent.most, d);
  }
  return extent;
}

Vec3 middle_of(const ClippedPolyhedron& common) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : common.vertices()) middle += x;
  return middle / static_cast<double>(common.vertices().size());
}

/// The faces to which depth is measured somewhere in a polyhedron, each plane once.
struct Candidates {
  std::array<std::uint32_t, kMostDepthPlanes> of;
  std::size_t count = 0;

  void add(const DepthPlanes& planes, std::size_t i) {
    constexpr double kSame = 1e-12;
    for (std::size_t k = 0; k < count; ++k) {
      const DepthPlane &a = planes[of[k]], &b = planes[i];
      if (std::abs(a.offset - b.offset) < kSame && (a.normal - b.normal).norm() < kSame) return;
    }
    of[count++] = static_cast<std::uint32_t>(i);
  }

  std::size_t nearest_to(const DepthPlanes& planes, const Vec3& x) const {
    double least = std::numeric_limits<double>::infinity();
    std::size_t at = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double depth = planes[of[k]].offset - planes[of[k]].normal.dot(x);
      if (!(depth < least)) continue;
      least = depth;
      at = k;
    }
    return at;
  }
};

/// Leaves of a polyhedron the part where candidate k is the nearest. First by the plane that is the
/// nearest in the middle of what is left, so that little is left for the others to look at.
bool cut_to_cell(ClippedPolyhedron& common, const DepthPlanes& planes, const Candidates& nearest,
                 std::size_t k) {
  const DepthPlane& plane = planes[nearest.of[k]];
  const auto cut = [&](std::size_t other) {
    const DepthPlane& farther = planes[nearest.of[other]];
    return common.cut(farther.normal - plane.normal, farther.offset - plane.offset,
                      kRidge + static_cast<std::uint32_t>(other));
  };
  for (std::size_t round = 0; round < nearest.count; ++round) {
    const std::size_t other = nearest.nearest_to(planes, middle_of(common));
    if (other == k) break;
    if (!cut(other)) return false;
  }
  for (std::size_t other = 0; other < nearest.count; ++other)
    if (other != k && !cut(other)) return false;
  return true;
}

/// Outside of a hollow the depth is that beyond the face which is farthest behind.
void add_hollow(const PlacedPart& tool, const ClippedPolyhedron& whole, const DepthPlanes& planes,
                bool slides, DepthSums& sums) {
  Candidates beyond;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (depth_extent(whole, planes[i]).least < 0.0) beyond.add(planes, i);
  for (std::size_t k = 0; k < beyond.count; ++k) {
    const DepthPlane& plane = planes[beyond.of[k]];
    ClippedPolyhedron common(whole);
    bool left = common.cut(-plane.normal, -plane.offset, beyond.of[k]);
    for (std::size_t other = 0; left && other < beyond.count; ++other) {
      if (other == k) continue;
      const DepthPlane& nearer = planes[beyond.of[other]];
      left = common.cut(nearer.normal - plane.normal, nearer.offset - plane.offset, kRidge);
    }
    if (left)
      add_cell(common, Cell(plane.normal, -plane.offset, tool.origin), planes, slides, sums);
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
    return inside.cut(planes[i].normal, planes[i].offset, static_cast<std::uint32_t>(i));
  };
  if (!cut(planes.facing())) return;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (!cut(i)) return;
  // A face can be the nearest somewhere only if it is nearer there than some other is everywhere.
  std::array<double, kMostDepthPlanes> least;
  double bound = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].inner) continue;
    const Extent extent = depth_extent(inside, planes[i]);
    least[i] = extent.least;
    bound = std::min(bound, extent.most);
  }
  Candidates nearest;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (!planes[i].inner && least[i] < bound) nearest.add(planes, i);
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
  look_at(nearest.nearest_to(planes, middle_of(inside)));
  while (next < count) {
    const std::size_t k = waiting[next++];
    const DepthPlane& plane = planes[nearest.of[k]];
    ClippedPolyhedron common(inside);
    if (!cut_to_cell(common, planes, nearest, k)) continue;
    add_cell(common, Cell(-plane.normal, plane.offset, tool.origin), planes, slides, sums);
    for (const auto& face : common.faces())
      if (face.tag >= kRidge && face.tag != ClippedPolyhedron::kOwn) look_at(face.tag - kRidge);
  }
}

}  // namespace feltwire
