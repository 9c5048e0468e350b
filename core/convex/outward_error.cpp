#include "core/convex/outward_error.hpp"

#include <algorithm>
#include <limits>
#include <queue>

#include "core/base/cancellation.hpp"

namespace feltwire {
namespace {

struct Box {
  double most = 0.0;  // [m] upper bound of the signed distance from the surface, over the box
  double distance = 0.0;
  Vec3 middle = Vec3::Zero(), half = Vec3::Zero();
  bool operator<(const Box& other) const { return most < other.most; }
};

bool misses(const ConvexHull& hull, const Box& box) {
  return std::ranges::any_of(hull.planes, [&](const HalfSpaceBelow& plane) {
    return plane.normal.dot(box.middle) - plane.normal.cwiseAbs().dot(box.half) > plane.offset;
  });
}

double signed_distance(const MeshSurface& solid, const Vec3& p, double within) {
  const auto nearest = solid.nearest(p, within);
  return solid.side_of(p, nearest) < 0.0 ? -nearest.distance : nearest.distance;
}

}  // namespace

double outward_error(const ConvexHull& hull, const MeshSurface& solid, double tolerance) {
  constexpr double kGap = 1.125;       // largest ratio of the true error to `found`
  constexpr double kWider = 1.000001;  // margin for rounding errors
  Bounds bounds;
  for (const Vec3& v : hull.vertices) bounds.add(v);
  double found = 0.0;
  std::priority_queue<Box> open;
  const auto add = [&](Box box, double within) {
    if (misses(hull, box)) return;
    box.distance = signed_distance(solid, box.middle, within);
    box.most = box.distance + box.half.norm();
    if (hull.contains(box.middle)) found = std::max(found, box.distance);
    if (box.most > std::max(tolerance, kGap * found)) open.push(box);
  };
  add({.middle = 0.5 * (bounds.least + bounds.most), .half = 0.5 * (bounds.most - bounds.least)},
      std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; !open.empty(); ++n) {
    check_cancelled(n);
    const Box box = open.top();
    if (box.most <= std::max(tolerance, kGap * found)) break;
    open.pop();
    Eigen::Index axis = 0;
    box.half.maxCoeff(&axis);
    for (const double side : {-1.0, 1.0}) {
      Box child = box;
      child.half[axis] *= 0.5;
      child.middle[axis] += side * child.half[axis];
      add(child, kWider * (std::abs(box.distance) + child.half[axis]));
    }
  }
  return found;
}

}  // namespace feltwire
