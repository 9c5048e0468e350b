#include "core/tool/point_shell.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/numeric.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kLeaf = 8;  // points

/// The additive recurrence in two dimensions with the least gaps known (Roberts 2018): the plastic
/// number and its square.
constexpr double kFirstStep = 0.7548776662466927, kSecondStep = 0.5698402909980532;

double part_of(double x) { return x - std::floor(x); }

double area_of(const TriangleSoup& surface, const Triangle& t) {
  const Vec3 a = surface.vertices[t[1]] - surface.vertices[t[0]];
  const Vec3 b = surface.vertices[t[2]] - surface.vertices[t[0]];
  return 0.5 * length(a.cross(b));
}

/// Equal steps along the area of triangle after triangle, evenly within each.
std::vector<Vec3> spread(const TriangleSoup& surface, double area, std::size_t count) {
  std::vector<Vec3> points;
  points.reserve(count);
  double before = 0.0;  // [m^2] of the triangles before this one
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
    if (u + v > 1.0) {  // the other half of the parallelogram, turned onto the triangle
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const Triangle& t = surface.triangles[triangle];
    const Vec3& corner = surface.vertices[t[0]];
    points.push_back(corner + u * (surface.vertices[t[1]] - corner) +
                     v * (surface.vertices[t[2]] - corner));
  }
  return points;
}

struct TreeBuilder {
  PointShell& shell;

  void build(std::uint32_t begin, std::uint32_t end) {
    const auto at = static_cast<std::ptrdiff_t>(begin), to = static_cast<std::ptrdiff_t>(end);
    const auto first = shell.points.begin();
    Vec3 low = shell.points[begin], high = low;
    for (auto p = first + at; p != first + to; ++p) {
      low = low.cwiseMin(*p);
      high = high.cwiseMax(*p);
    }
    ShellNode node;
    node.center = 0.5 * (low + high);
    node.begin = begin;
    node.end = end;
    for (auto p = first + at; p != first + to; ++p)
      node.radius = std::max(node.radius, (*p - node.center).norm());
    const std::size_t index = shell.nodes.size();
    shell.nodes.push_back(node);
    if (end - begin > kLeaf) {
      Eigen::Index axis;
      (high - low).maxCoeff(&axis);
      // The whole order, not only the middle: the same tree from every standard library.
      std::stable_sort(first + at, first + to,
                       [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
      const std::uint32_t middle = begin + (end - begin) / 2;
      build(begin, middle);
      build(middle, end);
    }
    shell.nodes[index].next = static_cast<std::uint32_t>(shell.nodes.size());
  }
};

}  // namespace

PointShell point_shell(const TriangleSoup& surface, std::size_t count) {
  if (count == 0 || count > kMaxShellPoints)
    throw std::invalid_argument("points: must be 1 to " + std::to_string(kMaxShellPoints) +
                                ", are " + std::to_string(count) + "; ten thousand are usual");
  PointShell shell;
  for (const Triangle& t : surface.triangles) shell.area += area_of(surface, t);
  if (!(shell.area > 0.0) || !std::isfinite(shell.area))
    throw std::invalid_argument("body: its surface has no area; give one that has");
  shell.points = spread(surface, shell.area, count);
  for (const Vec3& p : shell.points) shell.radius = std::max(shell.radius, p.norm());
  TreeBuilder{shell}.build(0, static_cast<std::uint32_t>(count));
  return shell;
}

}  // namespace feltwire
