#include "core/polyhedra/depth_integrals.hpp"

#include <algorithm>
#include <limits>

#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {
namespace {

using Tag = ClippedPolyhedron::Tag;

/// The tag of a plane between two cells: this and the other's candidate.
constexpr Tag kRidge = 0x8000;
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

/// One quantity of two triangles, computed together.
using Two = Eigen::Array2d;

/// Corners of two triangles, as a cell sees them.
struct TwoCorners {
  Two u, v, d;

  TwoCorners(const Vec3& first, const Vec3& second)
      : u(first.x(), second.x()), v(first.y(), second.y()), d(first.z(), second.z()) {}
};

/// Integrals over what a cell and the tool's part have in common. By Gauss that of f(u, v) d^n is
/// that of f d^(n + 1) / (n + 1) over the surface, projected on the face.
struct Moments {
  double cubes = 0.0;               // of d^3
  std::array<double, 3> squares{};  // of d^2 (1, u, v)
  std::array<double, 6> depths{};   // of d (1, u, v, u u, u v, v v)
};

/// The integrals of d^2 f g over the surface, for f and g of (1, u, v, d). For f and g linear on a
/// triangle with corners i,
///   integral of d^2 f g = area / 180 sum of f_i H_ij g_j,
/// H the second derivatives of the complete homogeneous polynomial of degree 4 in the depths of
/// the corners: H_ij = ((S + d_i + d_j)^2 + Q + d_i^2 + d_j^2) / 2, and twice that if i = j, with
/// S and Q the sums of the depths and of their squares.
class SurfaceMoments {
 public:
  void add(const TwoCorners& a, const TwoCorners& b, const TwoCorners& c) {
    const Two area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);  // twice
    if (area[0] == 0.0 && area[1] == 0.0) return;
    const Two sum = a.d + b.d + c.d;
    const Two aa = a.d * a.d, bb = b.d * b.d, cc = c.d * c.d, squared = aa + bb + cc;
    const Two sa = sum + 2.0 * a.d, sb = sum + 2.0 * b.d, sc = sum + 2.0 * c.d;
    const Two h00 = area * (sa * sa + squared + 2.0 * aa);
    const Two h11 = area * (sb * sb + squared + 2.0 * bb);
    const Two h22 = area * (sc * sc + squared + 2.0 * cc);
    const Two ta = sum + b.d + c.d, tb = sum + a.d + c.d, tc = sum + a.d + b.d;
    const Two half = 0.5 * area;
    const Two h12 = half * (ta * ta + squared + bb + cc);
    const Two h02 = half * (tb * tb + squared + aa + cc);
    const Two h01 = half * (tc * tc + squared + aa + bb);
    const Two one0 = h00 + h01 + h02, one1 = h01 + h11 + h12, one2 = h02 + h12 + h22;
    of_[0] += one0 + one1 + one2;
    of_[1] += one0 * a.u + one1 * b.u + one2 * c.u;
    of_[2] += one0 * a.v + one1 * b.v + one2 * c.v;
    of_[6] += one0 * a.d + one1 * b.d + one2 * c.d;
    const Two u0 = h00 * a.u + h01 * b.u + h02 * c.u, u1 = h01 * a.u + h11 * b.u + h12 * c.u,
              u2 = h02 * a.u + h12 * b.u + h22 * c.u;
    of_[3] += u0 * a.u + u1 * b.u + u2 * c.u;
    of_[4] += u0 * a.v + u1 * b.v + u2 * c.v;
    of_[7] += u0 * a.d + u1 * b.d + u2 * c.d;
    const Two v0 = h00 * a.v + h01 * b.v + h02 * c.v, v1 = h01 * a.v + h11 * b.v + h12 * c.v,
              v2 = h02 * a.v + h12 * b.v + h22 * c.v;
    of_[5] += v0 * a.v + v1 * b.v + v2 * c.v;
    of_[8] += v0 * a.d + v1 * b.d + v2 * c.d;
    of_[9] += (h00 * a.d + h01 * b.d + h02 * c.d) * a.d +
              (h01 * a.d + h11 * b.d + h12 * c.d) * b.d + (h02 * a.d + h12 * b.d + h22 * c.d) * c.d;
  }

  Moments moments() const {
    constexpr double kPart = 1.0 / 360.0;  // of twice the area
    const auto of = [&](std::size_t i) { return kPart * of_[i].sum(); };
    Moments m;
    for (std::size_t i = 0; i < m.depths.size(); ++i) m.depths[i] = of(i) / 2.0;
    for (std::size_t i = 0; i < m.squares.size(); ++i) m.squares[i] = of(6 + i) / 3.0;
    m.cubes = of(9) / 4.0;
    return m;
  }

 private:
  /// Of 1, u, v, u u, u v, v v, then d (1, u, v), then d d.
  std::array<Two, 10> of_ = zeros();
  static std::array<Two, 10> zeros() {
    std::array<Two, 10> all;
    all.fill(Two::Zero());
    return all;
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
void add_inner_face(const ClippedPolyhedron& common, std::span<const std::uint16_t> corners,
                    const Cell& cell, Vec6& slope) {
  const Vec3 a = common.corner(corners[0]);
  for (std::size_t k = 2; k < corners.size(); ++k) {
    const Vec3 b = common.corner(corners[k - 1]), c = common.corner(corners[k]);
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

/// `own`: the tag of faces on the plane to which the depth is measured.
void add_cell(const ClippedPolyhedron& common, const Cell& cell, Tag own, const DepthPlanes& planes,
              bool slides, DepthSums& sums) {
  SurfaceMoments surface;
  std::array<Vec3, ClippedPolyhedron::kCorners> seen;
  for (std::size_t i = 0; i < common.corner_count(); ++i) seen[i] = cell.seen(common.corner(i));
  Vec6 ends = Vec6::Zero();
  common.for_each_face([&](Tag tag, std::span<const std::uint16_t> corners) {
    if (tag == own) return;  // there the depth is zero
    const Vec3& a = seen[corners[0]];
    for (std::size_t k = 2; k < corners.size(); k += 2) {
      const Vec3 &b = seen[corners[k - 1]], &c = seen[corners[k]];
      const Vec3& d = seen[corners[std::min(k + 1, corners.size() - 1)]];
      surface.add({a, a}, {b, c}, {c, d});
    }
    if (tag < planes.size() && planes[tag].inner) add_inner_face(common, corners, cell, ends);
  });
  const Moments m = surface.moments();
  if (!(m.cubes > 0.0 && m.squares[0] > 0.0 && m.depths[0] > 0.0)) return;
  ++sums.cells;
  sums.slope += ends;
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

/// The depths of the corners of a polyhedron below a plane.
struct Extent {
  double least, most;
};
Extent depth_extent(const ClippedPolyhedron& common, const DepthPlane& plane) {
  alignas(16) std::array<double, ClippedPolyhedron::kCorners> depth;
  Eigen::Map<Eigen::ArrayXd, Eigen::Aligned16> depths(
      depth.data(), static_cast<Eigen::Index>(common.corner_count()));
  depths = plane.offset - (plane.normal.x() * common.x() + plane.normal.y() * common.y() +
                           plane.normal.z() * common.z());
  return {depths.minCoeff(), depths.maxCoeff()};
}

Vec3 middle_of(const ClippedPolyhedron& common) {
  return {common.x().mean(), common.y().mean(), common.z().mean()};
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
                      static_cast<Tag>(kRidge + other));
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
    add_cell(common, Cell(-plane.normal, plane.offset, tool.origin),
             static_cast<Tag>(nearest.of[k]), planes, slides, sums);
    for (std::size_t i = 0; i < common.corner_count(); ++i)
      for (const Tag tag : common.tags(i))
        if (tag >= kRidge && tag != ClippedPolyhedron::kOwn) look_at(tag - kRidge);
  }
}

}  // namespace feltwire
