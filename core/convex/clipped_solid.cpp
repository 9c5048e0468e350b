#include "core/convex/clipped_solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace feltwire {
namespace {

constexpr double kRounding = 1e-9;  // tolerance for rounding errors, as a share of the solid's size
constexpr int kAlongAxis = 15;      // number of cuts across each axis
constexpr std::size_t kHollow = 24;

/// Returns the height [m] of a point above the plane.
double height(const HalfSpaceBelow& plane, const Vec3& p) {
  return plane.normal.dot(p) - plane.offset;
}

Vec3 between(const Vec3& a, const Vec3& b, double height_a, double height_b) {
  return a + height_a / (height_a - height_b) * (b - a);
}

bool is_same(const HalfSpaceBelow& a, const HalfSpaceBelow& b, double rounding) {
  const double sign = a.normal.dot(b.normal) < 0.0 ? -1.0 : 1.0;
  return (a.normal - sign * b.normal).norm() < 1e-6 &&
         std::abs(a.offset - sign * b.offset) < rounding;
}

}  // namespace

ClippedSolid::ClippedSolid(const MeshSurface& solid)
    : solid_(&solid),
      rounding_(kRounding * solid.mesh().half_extents().maxCoeff()),
      vertices_(solid.mesh().vertices()) {
  polygons_.reserve(solid.mesh().triangles().size());
  for (const Triangle& t : solid.mesh().triangles()) polygons_.emplace_back(t.begin(), t.end());
}

std::vector<Vec3> ClippedSolid::corners_on(const HalfSpaceBelow& cut) const {
  std::vector<Vec3> found;
  for (std::size_t i = 0; i < cell_.size(); ++i)
    for (std::size_t k = i + 1; k < cell_.size(); ++k) {
      Mat3 normals;
      normals << cut.normal.transpose(), cell_[i].normal.transpose(), cell_[k].normal.transpose();
      constexpr double kParallel = 1e-9;
      if (std::abs(normals.determinant()) < kParallel) continue;
      const Vec3 p = normals.inverse() * Vec3(cut.offset, cell_[i].offset, cell_[k].offset);
      if (!p.allFinite() || std::ranges::any_of(cell_, [&](const HalfSpaceBelow& plane) {
            return height(plane, p) > rounding_;
          }))
        continue;
      const auto nearest = solid_->nearest(p, std::numeric_limits<double>::infinity());
      if (nearest.distance > rounding_ && solid_->side_of(p, nearest) < 0.0) found.push_back(p);
    }
  return found;
}

bool ClippedSolid::crosses(double a, double b) const {
  return std::min(a, b) < -rounding_ && std::max(a, b) > rounding_;
}

std::vector<double> ClippedSolid::heights_over(const HalfSpaceBelow& cut) const {
  std::vector<double> heights;
  heights.reserve(vertices_.size());
  for (const Vec3& v : vertices_) heights.push_back(height(cut, v));
  return heights;
}

// Returns the points below and above the cut. A vertex on the plane belongs to a side only if one
// of its polygons has another corner strictly on that side. Otherwise a face in the plane would
// become a part without volume.
std::pair<std::vector<Vec3>, std::vector<Vec3>> ClippedSolid::points_beside(
    const HalfSpaceBelow& cut) const {
  const std::vector<double> heights = heights_over(cut);
  std::pair<std::vector<Vec3>, std::vector<Vec3>> sides;
  std::vector<std::uint8_t> is_below(vertices_.size()), is_above(vertices_.size());
  for (const Polygon& polygon : polygons_) {
    const bool reaches_below =
        std::ranges::any_of(polygon, [&](std::uint32_t v) { return heights[v] < -rounding_; });
    const bool reaches_above =
        std::ranges::any_of(polygon, [&](std::uint32_t v) { return heights[v] > rounding_; });
    for (const std::uint32_t v : polygon) {
      if (reaches_below && heights[v] <= rounding_) is_below[v] = 1;
      if (reaches_above && heights[v] >= -rounding_) is_above[v] = 1;
    }
    if (!reaches_below || !reaches_above) continue;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint32_t a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      if (!crosses(heights[a], heights[b])) continue;
      const Vec3 p = between(vertices_[a], vertices_[b], heights[a], heights[b]);
      sides.first.push_back(p);
      sides.second.push_back(p);
    }
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (is_below[i] != 0) sides.first.push_back(vertices_[i]);
    if (is_above[i] != 0) sides.second.push_back(vertices_[i]);
  }
  const auto put = [&](const Vec3& p, double h) {
    if (h <= rounding_) sides.first.push_back(p);
    if (h >= -rounding_) sides.second.push_back(p);
  };
  for (const Vec3& p : corners_) put(p, height(cut, p));
  for (const Vec3& p : corners_on(cut)) put(p, 0.0);
  return sides;
}

ClippedSolid ClippedSolid::below(const HalfSpaceBelow& cut) const {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  const std::vector<double> heights = heights_over(cut);
  ClippedSolid part(*solid_, rounding_);
  part.cell_ = cell_;
  part.cell_.push_back(cut);
  std::vector<std::uint32_t> number(vertices_.size(), kNone);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> crossings;
  const auto make = [&](const Vec3& p) {
    part.vertices_.push_back(p);
    return static_cast<std::uint32_t>(part.vertices_.size() - 1);
  };
  for (const Polygon& polygon : polygons_) {
    if (std::ranges::none_of(polygon, [&](std::uint32_t v) { return heights[v] < -rounding_; }))
      continue;
    Polygon kept;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint32_t a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      if (heights[a] <= rounding_) {
        if (number[a] == kNone) number[a] = make(vertices_[a]);
        kept.push_back(number[a]);
      }
      if (!crosses(heights[a], heights[b])) continue;
      const auto [c, d] = std::minmax(a, b);
      const auto [at, is_new] = crossings.try_emplace({c, d}, 0);
      if (is_new) at->second = make(between(vertices_[c], vertices_[d], heights[c], heights[d]));
      kept.push_back(at->second);
    }
    part.polygons_.push_back(std::move(kept));
  }
  for (const Vec3& p : corners_)
    if (height(cut, p) <= rounding_) part.corners_.push_back(p);
  for (const Vec3& p : corners_on(cut)) part.corners_.push_back(p);
  return part;
}

std::vector<Vec3> ClippedSolid::points() const {
  std::vector<Vec3> all = vertices_;
  all.insert(all.end(), corners_.begin(), corners_.end());
  return all;
}

std::vector<HalfSpaceBelow> ClippedSolid::cuts() const {
  std::vector<HalfSpaceBelow> cuts;
  Bounds bounds;
  for (const Vec3& v : vertices_) bounds.add(v);
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 1; i <= kAlongAxis; ++i)
      cuts.push_back({Vec3::Unit(axis), bounds.least[axis] + (bounds.most - bounds.least)[axis] *
                                                                 i / (kAlongAxis + 1)});
  // A plane through a face at a hollow (concave) edge. At such an edge, a corner of the
  // neighbouring face lies above this face.
  struct Hollow {
    double weight;
    HalfSpaceBelow plane;
  };
  std::vector<Hollow> hollow;
  std::map<std::pair<std::uint32_t, std::uint32_t>, HalfSpaceBelow> waiting;
  for (const Polygon& polygon : polygons_) {
    // Newell's normal is correct for any polygon, even if some corners are collinear.
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < polygon.size(); ++k)
      sum += (vertices_[polygon[k]] - vertices_[polygon[0]])
                 .cross(vertices_[polygon[(k + 1) % polygon.size()]] - vertices_[polygon[0]]);
    if (!(sum.norm() > 0.0)) continue;
    const Vec3 normal = sum.normalized();
    const HalfSpaceBelow plane{normal, normal.dot(vertices_[polygon[0]])};
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint32_t a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      const auto [at, is_first] = waiting.try_emplace(std::minmax(a, b), plane);
      if (is_first) continue;
      const Vec3 along = vertices_[b] - vertices_[a];
      // The edge of this face from a to b is hollow if the other face's normal tilts towards this
      // face.
      const double bend = normal.cross(at->second.normal).dot(along);
      constexpr double kSharp = 1e-3;  // [rad] smaller angles count as flat
      if (bend >= -kSharp * along.norm()) continue;
      hollow.push_back({-bend, plane});
      hollow.push_back({-bend, at->second});
    }
  }
  std::ranges::stable_sort(hollow, std::greater<>(), &Hollow::weight);
  const std::size_t even = cuts.size();
  for (const Hollow& edge : hollow) {
    if (cuts.size() == even + kHollow) break;
    if (std::ranges::none_of(cuts, [&](const HalfSpaceBelow& known) {
          return is_same(known, edge.plane, rounding_);
        }))
      cuts.push_back(edge.plane);
  }
  return cuts;
}

}  // namespace feltwire
