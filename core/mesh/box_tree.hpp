#pragma once
// A tree of axis-aligned boxes, which finds the few of many items that can be near a place. It
// answers with candidates; the caller decides.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/types.hpp"
#include "core/base/work_limit.hpp"

namespace feltwire {

/// An axis-aligned box, from its least to its largest corner [m]. Empty at first.
struct Bounds {
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 most = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) {
    least = least.cwiseMin(p);
    most = most.cwiseMax(p);
  }
  Bounds grown(double by) const { return {least - Vec3::Constant(by), most + Vec3::Constant(by)}; }
  bool overlaps(const Bounds& other) const {
    return (least.array() <= other.most.array()).all() &&
           (other.least.array() <= most.array()).all();
  }
};

/// Immutable. Boxes are kept in float and rounded outwards. A query therefore misses no item whose
/// box (in double) fits it, but may visit a few others. The order of the visits is not defined.
/// Each node and each visit takes a unit of `work`; where it is cut off, visits are missing.
class BoxTree {
 public:
  /// [m] The squares of lengths still fit a float.
  static constexpr double kFarthest = 1e18;

  BoxTree() = default;
  /// Item i has boxes[i]; at most 2^30. The same boxes give the same tree. Throws
  /// std::invalid_argument if a box is not finite or reaches farther than kFarthest.
  explicit BoxTree(std::span<const Bounds> boxes);

  /// Visits every i whose box has a point in common with `box`.
  template <class Visit>
  void overlapping(const Bounds& box, Visit visit, WorkLimit* work = nullptr) const noexcept {
    const FloatBox q(box);
    descend([&](const Node& node, int child) { return overlaps(node, child, q); }, visit, work);
  }

  /// Visits every i whose box the straight way between two points can meet.
  template <class Visit>
  void along(const Vec3& from, const Vec3& to, Visit visit,
             WorkLimit* work = nullptr) const noexcept {
    Bounds box;
    box.add(from);
    box.add(to);
    const FloatBox q(box);
    const Vec3 middle = 0.5 * (from + to), half = 0.5 * (to - from);
    descend(
        [&](const Node& node, int child) {
          return overlaps(node, child, q) && !misses(node, child, middle, half);
        },
        visit, work);
  }

  /// Visits every i whose box is at most `radius()` [m] from the center. `radius()` is asked again
  /// before each box and may shrink between visits. Nearer boxes tend to come first.
  template <class Radius, class Visit>
  void within(const Vec3& center, Radius radius, Visit visit,
              WorkLimit* work = nullptr) const noexcept;

  bool empty() const { return nodes_.empty(); }
  std::size_t memory() const {
    return nodes_.capacity() * sizeof(Node) + items_.capacity() * sizeof(std::uint32_t);
  }

 private:
  static constexpr int kWidth = 4;
  static constexpr int kMostOpen = 160;  // kWidth - 1 more a level, and no tree has 52 levels
  static constexpr int kAxes = 3;

  struct FloatBox {
    explicit FloatBox(const Bounds& box);
    std::array<float, kAxes> least, most;
  };
  /// Children in slots 0 ... kWidth - 1; an empty one has a box that nothing overlaps.
  struct alignas(64) Node {
    std::array<std::array<float, kWidth>, kAxes> least, most;  // [m]
    std::array<std::uint32_t, kWidth> first;                   // node, or place in items_
    std::array<std::uint32_t, kWidth> count;                   // 0: a node, else a leaf's items
  };
  class Building;

  static bool overlaps(const Node& node, int child, const FloatBox& q) {
    const auto c = static_cast<std::size_t>(child);
    // All six are looked at: no branch is cheaper than one that is guessed wrong.
    int apart = 0;
    for (std::size_t axis = 0; axis < kAxes; ++axis)
      apart |= static_cast<int>(!(node.least[axis][c] <= q.most[axis])) |
               static_cast<int>(!(q.least[axis] <= node.most[axis][c]));
    return apart == 0;
  }
  static double square_distance(const Node& node, std::size_t child, const Vec3& p) {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      const double x = p[static_cast<Eigen::Index>(axis)];
      const double below = static_cast<double>(node.least[axis][child]) - x;
      const double above = x - static_cast<double>(node.most[axis][child]);
      const double out = std::max(0.0, std::max(below, above));
      sum += out * out;
    }
    return sum;
  }

  /// A line through the middle that passes beside the box: a plane through the line and an axis
  /// separates them (the edge axes of the separating axis test).
  static bool misses(const Node& node, int child, const Vec3& middle, const Vec3& half) {
    constexpr double kRounding = 1e-14;  // of products of coordinates, generously
    const auto c = static_cast<std::size_t>(child);
    Vec3 to_line, extent;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      const auto least = static_cast<double>(node.least[axis][c]);
      const auto most = static_cast<double>(node.most[axis][c]);
      to_line[static_cast<Eigen::Index>(axis)] =
          middle[static_cast<Eigen::Index>(axis)] - 0.5 * (least + most);
      extent[static_cast<Eigen::Index>(axis)] = 0.5 * (most - least);
    }
    const Vec3 way = half.cwiseAbs();
    const double rounding = kRounding * (middle.cwiseAbs().maxCoeff() * way.maxCoeff());
    const Vec3 apart = to_line.cross(half).cwiseAbs();
    return apart.x() > extent.y() * way.z() + extent.z() * way.y() + rounding ||
           apart.y() > extent.z() * way.x() + extent.x() * way.z() + rounding ||
           apart.z() > extent.x() * way.y() + extent.y() * way.x() + rounding;
  }

  template <class Enter, class Visit>
  void descend(Enter enter, Visit& visit, WorkLimit* work) const noexcept {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, kMostOpen> open;
    int count = 0;
    open[0] = 0;
    count = 1;
    while (count > 0 && may_go_on(work)) {
      const Node& node = nodes_[open[static_cast<std::size_t>(--count)]];
      for (int child = 0; child < kWidth; ++child) {
        if (!enter(node, child)) continue;
        const auto c = static_cast<std::size_t>(child);
        if (node.count[c] == 0)
          open[static_cast<std::size_t>(count++)] = node.first[c];
        else if (may_go_on(work, node.count[c]))
          for (std::uint32_t i = 0; i < node.count[c]; ++i) visit(items_[node.first[c] + i]);
      }
    }
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

template <class Radius, class Visit>
void BoxTree::within(const Vec3& center, Radius radius, Visit visit,
                     WorkLimit* work) const noexcept {
  struct Open {
    double square;
    std::uint32_t first, count;
  };
  if (nodes_.empty()) return;
  std::array<Open, kMostOpen> open;
  std::size_t count = 1;
  open[0] = {0.0, 0, 0};
  while (count > 0) {
    const Open here = open[--count];
    if (!(here.square <= radius() * radius())) continue;
    if (!may_go_on(work, std::max<std::uint32_t>(1, here.count))) return;
    for (std::uint32_t i = 0; i < here.count; ++i) visit(items_[here.first + i]);
    if (here.count > 0) continue;
    const Node& node = nodes_[here.first];
    const std::size_t before = count;
    for (std::size_t c = 0; c < kWidth; ++c) {
      const Open child{square_distance(node, c, center), node.first[c], node.count[c]};
      if (!(child.square <= radius() * radius())) continue;
      std::size_t place = count++;  // the nearest last, so that it is taken first
      for (; place > before && open[place - 1].square < child.square; --place)
        open[place] = open[place - 1];
      open[place] = child;
    }
  }
}

}  // namespace feltwire
