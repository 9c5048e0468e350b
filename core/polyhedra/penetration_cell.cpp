#include "core/polyhedra/penetration_cell.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/polyhedra/simd4.hpp"

namespace feltwire {
namespace {

using Tag = ClosestFaceCells::Tag;
using Corner = std::uint16_t;

/// The six-point quadrature rule of degree four on a triangle (Strang & Fix 1973). The weights are
/// shares of the area, and `at` has barycentric coordinates.
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

/// A corner of a cell, and the index of this cell among the corner's four faces.
struct CellCorner {
  Corner corner;
  std::uint8_t slot;
};

/// Lists the corners of each of the first `count` cells.
class CornersByCell {
 public:
  CornersByCell(const ClosestFaceCells& cells, std::size_t count) {
    std::fill_n(end_.begin(), count, std::uint16_t{0});
    for_each(cells, count, [&](std::size_t cell, CellCorner) { ++end_[cell]; });
    std::uint16_t begin = 0;
    for (std::size_t k = 0; k < count; ++k) begin += std::exchange(end_[k], begin);
    for_each(cells, count, [&](std::size_t cell, CellCorner at) { all_[end_[cell]++] = at; });
  }
  std::span<const CellCorner> operator[](std::size_t cell) const {
    const std::size_t begin = cell == 0 ? 0 : end_[cell - 1];
    return std::span(all_).subspan(begin, end_[cell] - begin);
  }

 private:
  template <class Visit>
  static void for_each(const ClosestFaceCells& cells, std::size_t count, const Visit& visit) {
    for (std::size_t i = 0; i < cells.corner_count(); ++i)
      for (std::uint8_t slot = 0; slot < 4; ++slot) {
        const std::size_t cell = std::size_t{cells.faces(i)[slot]} - ClosestFaceCells::kCell;
        if (cell < count) visit(cell, {static_cast<Corner>(i), slot});
      }
  }
  std::array<std::uint16_t, ClosestFaceCells::kMostCells> end_;
  std::array<CellCorner, 4 * ClosestFaceCells::kCorners> all_;
};

/// The corners of a cell in the cell's coordinates: u and v along the face from the tool's origin,
/// and d for the depth.
struct SeenCorners {
  static constexpr std::size_t kMost = ClosestFaceCells::kCorners;
  std::array<double, kMost> u, v, d;

  SeenCorners(const ClosestFaceCells& cells, std::span<const CellCorner> corners,
              const PenetrationCell& cell) {
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec3 at = cells.corner(corners[k].corner);
      u[k] = cell.across.dot(at - cell.origin);
      v[k] = cell.along.dot(at - cell.origin);
      d[k] = cell.inwards.dot(at) + cell.constant;
    }
  }
};

/// A triangle of the surface, as indices of its corners.
using Facet = std::array<Corner, 3>;

/// Integrals over the intersection of a cell and the tool's part. By Gauss's theorem, the integral
/// of f(u, v) d^n equals the integral of f d^(n + 1) / (n + 1) over the surface, projected on the
/// face.
struct Moments {
  double cubes = 0.0;               // integral of d^3
  std::array<double, 3> squares{};  // integrals of d^2 (1, u, v)
  std::array<double, 6> depths{};   // integrals of d (1, u, v, u u, u v, v v)
};

}  // namespace

/// Integrals of d^2 f g over the surface, for f and g from (1, u, v, d). If f and g are linear on a
/// triangle with corners i, then
///   integral of d^2 f g = area / 180 sum of f_i H_ij g_j.
/// H has the second derivatives of the complete homogeneous polynomial of degree 4 in the depths of
/// the corners: H_ij = ((S + d_i + d_j)^2 + Q + d_i^2 + d_j^2) / 2, and twice this value if i = j.
/// S is the sum of the depths. Q is the sum of their squares.
/// The order is 1, u, v, u u, u v, v v, then d (1, u, v), then d d. Each value is multiplied by
/// 360.
using SurfaceSums = std::array<double, 10>;

/// Adds the integrals of four facets, one facet per lane. A facet with equal corners adds zero.
__attribute__((always_inline)) static inline void add_four(const SeenCorners& seen,
                                                           const Facet* facets, Double4* of) {
  const double *u = seen.u.data(), *v = seen.v.data(), *d = seen.d.data();
  const Facet &p = facets[0], &q = facets[1], &r = facets[2], &s = facets[3];
  const Double4 au = {u[p[0]], u[q[0]], u[r[0]], u[s[0]]},
                av = {v[p[0]], v[q[0]], v[r[0]], v[s[0]]},
                ad = {d[p[0]], d[q[0]], d[r[0]], d[s[0]]},
                bu = {u[p[1]], u[q[1]], u[r[1]], u[s[1]]},
                bv = {v[p[1]], v[q[1]], v[r[1]], v[s[1]]},
                bd = {d[p[1]], d[q[1]], d[r[1]], d[s[1]]},
                cu = {u[p[2]], u[q[2]], u[r[2]], u[s[2]]},
                cv = {v[p[2]], v[q[2]], v[r[2]], v[s[2]]},
                cd = {d[p[2]], d[q[2]], d[r[2]], d[s[2]]};
  const Double4 area = (bu - au) * (cv - av) - (bv - av) * (cu - au);  // twice the area
  const Double4 sum = ad + bd + cd;
  const Double4 aa = ad * ad, bb = bd * bd, cc = cd * cd, squared = aa + bb + cc;
  const Double4 sa = sum + 2.0 * ad, sb = sum + 2.0 * bd, sc = sum + 2.0 * cd;
  const Double4 h00 = area * (sa * sa + squared + 2.0 * aa);
  const Double4 h11 = area * (sb * sb + squared + 2.0 * bb);
  const Double4 h22 = area * (sc * sc + squared + 2.0 * cc);
  const Double4 ta = sum + bd + cd, tb = sum + ad + cd, tc = sum + ad + bd;
  const Double4 half = 0.5 * area;
  const Double4 h12 = half * (ta * ta + squared + bb + cc);
  const Double4 h02 = half * (tb * tb + squared + aa + cc);
  const Double4 h01 = half * (tc * tc + squared + aa + bb);
  const Double4 one0 = h00 + h01 + h02, one1 = h01 + h11 + h12, one2 = h02 + h12 + h22;
  of[0] += one0 + one1 + one2;
  of[1] += one0 * au + one1 * bu + one2 * cu;
  of[2] += one0 * av + one1 * bv + one2 * cv;
  of[6] += one0 * ad + one1 * bd + one2 * cd;
  const Double4 u0 = h00 * au + h01 * bu + h02 * cu, u1 = h01 * au + h11 * bu + h12 * cu,
                u2 = h02 * au + h12 * bu + h22 * cu;
  of[3] += u0 * au + u1 * bu + u2 * cu;
  of[4] += u0 * av + u1 * bv + u2 * cv;
  of[7] += u0 * ad + u1 * bd + u2 * cd;
  const Double4 v0 = h00 * av + h01 * bv + h02 * cv, v1 = h01 * av + h11 * bv + h12 * cv,
                v2 = h02 * av + h12 * bv + h22 * cv;
  of[5] += v0 * av + v1 * bv + v2 * cv;
  of[8] += v0 * ad + v1 * bd + v2 * cd;
  of[9] += (h00 * ad + h01 * bd + h02 * cd) * ad + (h01 * ad + h11 * bd + h12 * cd) * bd +
           (h02 * ad + h12 * bd + h22 * cd) * cd;
}

/// Computes the integrals of all facets. The number of facets is a multiple of four.
FELTWIRE_ALSO_AVX2 static void sum_surface(const SeenCorners& seen, std::span<const Facet> facets,
                                           SurfaceSums& sums) {
  Double4 of[10] = {};
  for (std::size_t t = 0; t < facets.size(); t += 4) add_four(seen, &facets[t], of);
  for (std::size_t i = 0; i < sums.size(); ++i)
    sums[i] = (of[i][0] + of[i][1]) + (of[i][2] + of[i][3]);
}

/// Adds the integrals of each facet of a ridge (the border of two cells) to the cell beyond the
/// ridge. `facets` is padded to a multiple of four.
FELTWIRE_ALSO_AVX2 static void add_ridges(const SeenCorners& seen, std::span<const Facet> facets,
                                          std::span<const Corner> beyond, SurfaceSums* sums) {
  for (std::size_t t = 0; t < beyond.size(); t += 4) {
    Double4 of[10] = {};
    add_four(seen, &facets[t], of);
    for (std::size_t lane = 0; lane < 4 && t + lane < beyond.size(); ++lane) {
      SurfaceSums& own = sums[beyond[t + lane]];
      for (std::size_t i = 0; i < own.size(); ++i) own[i] += of[i][lane];
    }
  }
}

namespace {

Moments moments_of(const SurfaceSums& sums) {
  constexpr double kPart = 1.0 / 360.0;  // factor per twice the area
  Moments m;
  for (std::size_t i = 0; i < m.depths.size(); ++i) m.depths[i] = kPart * sums[i] / 2.0;
  for (std::size_t i = 0; i < m.squares.size(); ++i) m.squares[i] = kPart * sums[6 + i] / 3.0;
  m.cubes = kPart * sums[9] / 4.0;
  return m;
}

std::size_t side_of(const Vec3& way) {
  Eigen::Index axis;
  way.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::size_t>(axis) + (way[axis] < 0.0 ? 1 : 0);
}

/// A motion (t, w) of the tool moves the point at (u, v) out of the solid by (W_0 + v W_1 + u W_2)
/// . (t, w). The members are W_0, W_1 and W_2.
struct PointMotion {
  Vec6 translation, about_across, about_along;

  explicit PointMotion(const PenetrationCell& cell) {
    translation << -cell.inwards, Vec3::Zero();
    about_across << Vec3::Zero(), -cell.across;
    about_along << Vec3::Zero(), cell.along;
  }
};

void add_slip(const PenetrationCell& cell, const Moments& m, DepthSums& sums) {
  const double weight = m.squares[0];
  const double u = m.squares[1] / weight, v = m.squares[2] / weight;
  const double d = m.cubes / weight - cell.constant - cell.inwards.dot(cell.origin);
  const Vec3 centre = u * cell.across + v * cell.along + d * cell.inwards;
  // Compute the covariance along the face, weighted by the depth.
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

/// Adds to `slope` the part of one triangle of a face where the tool's part ends inside the solid.
void add_inner(const std::array<Vec3, 3>& corners, const PenetrationCell& cell, Vec6& slope) {
  const auto& [a, b, c] = corners;
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

/// The surface of a cell as triangles. One object serves all cells in turn.
class CellSurface {
 public:
  CellSurface(const ClosestFaceCells& cells, const DepthPlanes& planes)
      : cells_(cells), planes_(planes) {
    for (std::size_t i = 0; i < cells.corner_count(); ++i)
      for (const Tag tag : cells.faces(i)) seen_[tag].turn = 0;
  }

  /// Computes the triangles on the surface of cell k, except those on the plane from which the
  /// depth is measured. `corners` are the cell's corners. Adds to `ends` the faces where the tool's
  /// part ends inside the solid.
  void take(std::size_t k, std::span<const CellCorner> corners, const PenetrationCell& cell,
            Vec6& ends) {
    const std::uint16_t turn = ++turn_;
    for (std::size_t c = 0; c < corners.size(); ++c)
      place_[corners[c].corner] = static_cast<Corner>(c);
    std::array<std::size_t, 2> count{};
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const std::size_t at = corners[c].corner;
      const auto& way = cells_.around(at, corners[c].slot);
      const auto here = static_cast<Corner>(c);
      for (std::size_t i = 0; i < 3; ++i) {
        const Tag tag = cells_.faces(at)[way[i]];
        const Corner next = place_[cells_.beyond(at, way[(i + 2) % 3])];
        // The triangles of a face form a fan around its first corner.
        CornerTurn& seen = seen_[tag];
        const Corner first = seen.turn == turn ? seen.corner : here;
        seen = {turn, first};
        const std::size_t ridge =
            tag > ClosestFaceCells::kCell + k && tag < ClippedPolyhedron::kOwn;
        facets_[ridge][count[ridge]] = {first, here, next};
        beyond_[count[1]] = static_cast<Corner>(tag - ClosestFaceCells::kCell);
        const bool left_out = (first == here) | (first == next) | (tag == cell.own);
        count[ridge] += left_out ? 0 : 1;
        if (tag < planes_.size() && planes_[tag].inner && !left_out) [[unlikely]]
          add_inner({cells_.corner(corners[first].corner), cells_.corner(at),
                     cells_.corner(corners[next].corner)},
                    cell, ends);
      }
    }
    ridge_count_ = count[1];
    for (std::size_t ridge = 0; ridge < 2; ++ridge) {
      while (count[ridge] % 4 != 0) facets_[ridge][count[ridge]++] = {};
      spans_[ridge] = std::span(facets_[ridge]).first(count[ridge]);
    }
  }
  /// Returns the triangles, except those that this cell shares with a cell of a higher index.
  /// Triangles without area pad the list to a multiple of four.
  std::span<const Facet> facets() const { return spans_[0]; }
  /// Returns the triangles that this cell shares with cells of a higher index, padded too. beyond()
  /// returns the indices of these cells, without padding.
  std::span<const Facet> ridge_facets() const { return spans_[1]; }
  std::span<const Corner> beyond() const { return std::span(beyond_).first(ridge_count_); }

 private:
  struct CornerTurn {
    std::uint16_t turn;
    Corner corner;
  };
  const ClosestFaceCells& cells_;
  const DepthPlanes& planes_;
  std::uint16_t turn_ = 0;  // number of calls of take()
  std::array<CornerTurn, ClippedPolyhedron::kOwn + 3 * kMostPolyhedronVertices> seen_;
  std::array<Corner, ClosestFaceCells::kCorners> place_;
  // Three edges meet at each corner, so there are fewer than two triangles per corner.
  static constexpr std::size_t kMost = 2 * ClosestFaceCells::kCorners + 4;
  std::array<std::array<Facet, kMost>, 2> facets_;
  std::array<Corner, kMost> beyond_;
  std::array<std::span<const Facet>, 2> spans_;
  std::size_t ridge_count_ = 0;
};

/// Adds to `ridges` the amount by which a ridge (the border of two cells) reduces the curvature.
/// `s` has the integrals of d^2 f g over the ridge, for f and g from (1, u, v, d), projected on the
/// face of an adjacent cell.
void add_ridge(const PenetrationCell& cell, const PenetrationCell& beyond, const SurfaceSums& s,
               Mat6& ridges) {
  constexpr double kPart = 6.0 / 360.0;  // factor per twice the area
  const Vec3 across = (cell.inwards - beyond.inwards).normalized();
  const double depth = cell.constant + cell.inwards.dot(cell.origin);  // depth of the tool's origin
  Eigen::Matrix4d sums;
  sums << s[0], s[1], s[2], s[6],  //
      s[1], s[3], s[4], s[7],      //
      s[2], s[4], s[5], s[8],      //
      s[6], s[7], s[8], s[9];
  Eigen::Matrix<double, 3, 4> arms;  // arm x across for 1, u, v, d
  const Vec3 turned = cell.inwards.cross(across);
  arms << -depth * turned, cell.across.cross(across), cell.along.cross(across), turned;
  const Eigen::Matrix<double, 3, 4> weighted = kPart * arms * sums;
  ridges.topLeftCorner<3, 3>() += kPart * s[0] * across * across.transpose();
  ridges.topRightCorner<3, 3>() += across * weighted.col(0).transpose();
  ridges.bottomLeftCorner<3, 3>() += weighted.col(0) * across.transpose();
  ridges.bottomRightCorner<3, 3>() += weighted * arms.transpose();
}

void add_cell(const Moments& m, const PenetrationCell& cell, bool slides, DepthSums& sums) {
  ++sums.cells;
  sums.cubes += m.cubes;
  const PointMotion w(cell);
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

}  // namespace

void add_cells(const ClosestFaceCells& cells, std::span<const PenetrationCell> of,
               const DepthPlanes& planes, bool slides, DepthSums& sums) noexcept {
  const CornersByCell by_cell(cells, of.size());
  CellSurface surface(cells, planes);
  // Integrals over the ridges of the current cell, indexed by the cell beyond the ridge.
  std::array<SurfaceSums, ClosestFaceCells::kMostCells> beyond;
  std::fill_n(beyond.begin(), of.size(), SurfaceSums{});
  for (std::size_t k = 0; k < of.size(); ++k) {
    const auto corners = by_cell[k];
    if (corners.empty()) continue;
    Vec6 ends = Vec6::Zero();
    surface.take(k, corners, of[k], ends);
    const SeenCorners seen(cells, corners, of[k]);
    SurfaceSums whole;
    sum_surface(seen, surface.facets(), whole);
    add_ridges(seen, surface.ridge_facets(), surface.beyond(), beyond.data());
    Mat6 ridges = Mat6::Zero();
    for (std::size_t j = k + 1; j < of.size(); ++j) {
      if (beyond[j][0] == 0.0) continue;
      const SurfaceSums own = std::exchange(beyond[j], SurfaceSums{});
      for (std::size_t i = 0; i < own.size(); ++i) whole[i] += own[i];
      add_ridge(of[k], of[j], own, ridges);
    }
    const Moments m = moments_of(whole);
    if (!(m.cubes > 0.0 && m.squares[0] > 0.0 && m.depths[0] > 0.0)) continue;
    sums.slope += ends;
    sums.ridges += ridges;
    add_cell(m, of[k], slides, sums);
  }
}

}  // namespace feltwire
