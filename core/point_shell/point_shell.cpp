#include "core/point_shell/point_shell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

/// Steps of the two-dimensional additive recurrence with the smallest known gaps (Roberts 2018).
/// The first step is 1 / the plastic number, and the second step is its square.
constexpr double kFirstStep = 0.7548776662466927, kSecondStep = 0.5698402909980532;

double part_of(double x) { return x - std::floor(x); }

double area_of(const TriangleSoup& surface, const Triangle& t) {
  const Vec3 a = surface.vertices[t[1]] - surface.vertices[t[0]];
  const Vec3 b = surface.vertices[t[2]] - surface.vertices[t[0]];
  return 0.5 * length(a.cross(b));
}

constexpr std::size_t kSides = 6;
/// Returns the index of the signed axis that is nearest to the triangle's normal.
std::size_t side_of(const TriangleSoup& surface, const Triangle& t) {
  const Vec3 a = surface.vertices[t[1]] - surface.vertices[t[0]];
  const Vec3 normal = a.cross(surface.vertices[t[2]] - surface.vertices[t[0]]);
  Eigen::Index axis;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::size_t>(axis) + (normal[axis] < 0.0 ? 1 : 0);
}

using Sides = std::array<std::vector<Vec3>, kSides>;

/// Spreads points in equal steps of area over all triangles, and evenly within each triangle.
std::vector<Vec3> spread(const TriangleSoup& surface, double area, std::size_t count,
                         Sides& sides) {
  std::vector<Vec3> points;
  points.reserve(count);
  double before = 0.0;  // [m^2] area of the previous triangles
  std::size_t triangle = 0;
  double here = area_of(surface, surface.triangles[0]);
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<double>(i) + 0.5;
    const double wanted = area * n / static_cast<double>(count);
    while (before + here < wanted && triangle + 1 < surface.triangles.size()) {
      before += here;
      here = area_of(surface, surface.triangles[++triangle]);
    }
    double u = part_of(n * kFirstStep), v = part_of(n * kSecondStep);
    if (u + v > 1.0) {  // Mirror a point of the parallelogram's other half.
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const Triangle& t = surface.triangles[triangle];
    const Vec3& corner = surface.vertices[t[0]];
    points.push_back(corner + u * (surface.vertices[t[1]] - corner) +
                     v * (surface.vertices[t[2]] - corner));
    sides[side_of(surface, t)].push_back(points.back());
  }
  return points;
}

/// Divides the shell into up to eight parts, and each part again. So the children of a node, or the
/// points of a leaf, fill a vector.
struct TreeBuilder {
  PointShell& shell;
  static constexpr std::uint32_t kParts = ShellNode::kParts;

  ShellNode node_of(std::uint32_t begin, std::uint32_t end) const {
    Vec3 low = shell.points[begin], high = low;
    for (std::uint32_t i = begin; i < end; ++i) {
      low = low.cwiseMin(shell.points[i]);
      high = high.cwiseMax(shell.points[i]);
    }
    ShellNode node;
    node.center = 0.5 * (low + high);
    node.begin = begin;
    node.end = end;
    for (std::uint32_t i = begin; i < end; ++i)
      node.radius = std::max(node.radius, (shell.points[i] - node.center).norm());
    return node;
  }

  /// Splits a range in two along the longest side of its bounding box. The first part has only full
  /// leaves. Returns the index of the split.
  std::uint32_t halve(std::uint32_t begin, std::uint32_t end) {
    const auto first = shell.points.begin() + static_cast<std::ptrdiff_t>(begin),
               last = shell.points.begin() + static_cast<std::ptrdiff_t>(end);
    Vec3 low = *first, high = low;
    for (auto p = first; p != last; ++p) {
      low = low.cwiseMin(*p);
      high = high.cwiseMax(*p);
    }
    Eigen::Index axis;
    (high - low).maxCoeff(&axis);
    // Sort completely instead of only to the middle, so that every standard library makes the same
    // tree.
    std::stable_sort(first, last,
                     [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    const std::uint32_t leaves = (end - begin + kParts - 1) / kParts;
    return begin + (leaves + 1) / 2 * kParts;
  }

  /// Splits a range `cuts` times in two and appends the ends of the parts to `ends`.
  void cut(std::uint32_t begin, std::uint32_t end, int cuts, std::vector<std::uint32_t>& ends) {
    if (cuts == 0 || end - begin <= kParts) {
      ends.push_back(end);
      return;
    }
    const std::uint32_t middle = halve(begin, end);
    cut(begin, middle, cuts - 1, ends);
    cut(middle, end, cuts - 1, ends);
  }

  void divide(std::size_t index) {
    constexpr int kCuts = 3;  // kParts = 2^3
    const std::uint32_t begin = shell.nodes[index].begin, end = shell.nodes[index].end;
    if (end - begin <= kParts) return;
    std::vector<std::uint32_t> ends;
    cut(begin, end, kCuts, ends);
    const auto child = static_cast<std::uint32_t>(shell.nodes.size());
    std::uint32_t from = begin;
    for (const std::uint32_t to : ends) {
      shell.nodes.push_back(node_of(from, to));
      from = to;
    }
    shell.nodes[index].child = child;
    shell.nodes[index].children = static_cast<std::uint32_t>(ends.size());
    for (std::size_t i = 0; i < ends.size(); ++i) divide(child + i);
  }

  void build() {
    shell.nodes.push_back(node_of(0, static_cast<std::uint32_t>(shell.points.size())));
    divide(0);
  }
};

void finish(PointShell& shell) {
  for (const Vec3& p : shell.points) shell.radius = std::max(shell.radius, p.norm());
  TreeBuilder{shell}.build();
}

}  // namespace

PointShell point_shell(const TriangleSoup& surface, std::size_t count) {
  if (count == 0 || count > kMaxShellPoints)
    throw std::invalid_argument("points: must be 1 to " + std::to_string(kMaxShellPoints) +
                                ", are " + std::to_string(count) + "; ten thousand are usual");
  PointShell shell;
  for (const Triangle& t : surface.triangles) shell.area += area_of(surface, t);
  if (!(shell.area > 0.0) || !std::isfinite(shell.area))
    throw std::invalid_argument("body: its surface has no area; give one that has");
  Sides sides;
  shell.points = spread(surface, shell.area, count, sides);
  finish(shell);
  for (std::vector<Vec3>& points : sides) {
    if (points.empty()) continue;
    const double share = static_cast<double>(points.size()) / static_cast<double>(count);
    shell.sides.push_back(point_shell(std::move(points), shell.area * share));
  }
  return shell;
}

PointShell point_shell(std::vector<Vec3> points, double area) {
  PointShell shell;
  shell.area = area;
  shell.points = std::move(points);
  finish(shell);
  return shell;
}

}  // namespace feltwire
