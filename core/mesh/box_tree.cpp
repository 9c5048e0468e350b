// Builds the tree top-down. The surface area heuristic (Goldsmith, Salmon 1987) with bins (Wald
// 2007) splits each node into up to four parts.

#include "core/mesh/box_tree.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/parallel.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kMostInLeaf = 4;
constexpr std::size_t kBins = 16;
/// From this level of the tree on, each split halves the items regardless of its cost. This limits
/// the depth of the tree.
constexpr int kMaxUneven = 24;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float below(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafter(f, -kInfinity);
}
float above(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, kInfinity);
}

using Corner = std::array<float, 3>;

/// A box that grows. It is empty at first.
struct Hull {
  Corner least{kInfinity, kInfinity, kInfinity}, most{-kInfinity, -kInfinity, -kInfinity};

  void add(const Corner& from, const Corner& to) {
    for (std::size_t axis = 0; axis < least.size(); ++axis) {
      least[axis] = std::min(least[axis], from[axis]);
      most[axis] = std::max(most[axis], to[axis]);
    }
  }
  void add(const Hull& other) { add(other.least, other.most); }
  /// Returns half the surface area [m^2], or 0 if the box is empty.
  double area() const {
    const auto side = [&](std::size_t axis) {
      return std::max(0.0, static_cast<double>(most[axis]) - static_cast<double>(least[axis]));
    };
    return side(0) * side(1) + side(1) * side(2) + side(2) * side(0);
  }
};

struct Item {
  Hull box;
  std::uint32_t index = 0;
  /// Returns twice the middle of the box along the axis.
  float middle(std::size_t axis) const { return box.least[axis] + box.most[axis]; }
};

/// A range of items and its bounding box.
struct Part {
  std::size_t begin = 0, end = 0;
  Hull box;
  std::size_t size() const { return end - begin; }
};

/// Bins of items along an axis, by the middles of their boxes. A cut lies between two bins.
struct Bins {
  float first = kInfinity, per_bin = 0.0f;
  std::array<Hull, kBins> boxes{};
  std::array<std::size_t, kBins> counts{};

  std::size_t bin_of(float middle) const {
    return std::min(kBins - 1,
                    static_cast<std::size_t>(std::max(0.0f, (middle - first) * per_bin)));
  }
};

struct Cut {
  std::size_t axis = 0;
  std::size_t bin = 0;  // index of the first bin of the second part; 0 if there is no cut
  double cost = std::numeric_limits<double>::infinity();
};

Part part_of(const std::vector<Item>& items, std::size_t begin, std::size_t end) {
  Part part{begin, end, {}};
  for (std::size_t i = begin; i < end; ++i) part.box.add(items[i].box);
  return part;
}

/// Returns the bins of all axes. `per_bin` is zero along an axis on which all middles coincide.
std::array<Bins, 3> bins_of(const std::vector<Item>& items, const Part& part) {
  std::array<Bins, 3> bins;
  Corner last{-kInfinity, -kInfinity, -kInfinity};
  for (std::size_t i = part.begin; i < part.end; ++i)
    for (std::size_t axis = 0; axis < bins.size(); ++axis) {
      bins[axis].first = std::min(bins[axis].first, items[i].middle(axis));
      last[axis] = std::max(last[axis], items[i].middle(axis));
    }
  for (std::size_t axis = 0; axis < bins.size(); ++axis) {
    const float per_bin = static_cast<float>(kBins) / (last[axis] - bins[axis].first);
    if (last[axis] > bins[axis].first && std::isfinite(per_bin)) bins[axis].per_bin = per_bin;
  }
  for (std::size_t i = part.begin; i < part.end; ++i)
    for (Bins& of_axis : bins) {
      if (of_axis.per_bin == 0.0f) continue;
      const auto axis = static_cast<std::size_t>(&of_axis - bins.data());
      const std::size_t bin = of_axis.bin_of(items[i].middle(axis));
      of_axis.boxes[bin].add(items[i].box);
      ++of_axis.counts[bin];
    }
  return bins;
}

/// Returns the cheapest cut between two bins of an axis.
Cut best_cut(const Bins& bins, std::size_t axis, std::size_t size) {
  Cut cut{.axis = axis};
  // First compute the cost of the items behind each cut. Then add the cost of the items before the
  // cut.
  std::array<double, kBins> behind{};
  Hull hull;
  std::size_t count = 0;
  for (std::size_t bin = kBins; bin-- > 1;) {
    hull.add(bins.boxes[bin]);
    count += bins.counts[bin];
    behind[bin] = hull.area() * static_cast<double>(count);
  }
  hull = {};
  count = 0;
  for (std::size_t bin = 1; bin < kBins; ++bin) {
    hull.add(bins.boxes[bin - 1]);
    count += bins.counts[bin - 1];
    if (count == 0 || count == size) continue;
    const double cost = hull.area() * static_cast<double>(count) + behind[bin];
    if (!(cost < cut.cost)) continue;
    cut.cost = cost;
    cut.bin = bin;
  }
  return cut;
}

/// Splits a range into two parts and moves the items of each part together.
std::array<Part, 2> halves(std::vector<Item>& items, const Part& part, int level) {
  const auto at = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
  std::array<Bins, 3> bins;
  Cut best;
  if (level < kMaxUneven) {
    bins = bins_of(items, part);
    for (std::size_t axis = 0; axis < bins.size(); ++axis)
      if (const Cut cut = best_cut(bins[axis], axis, part.size()); cut.cost < best.cost) best = cut;
  }
  std::size_t middle = part.begin + part.size() / 2;
  if (best.bin > 0) {
    const auto before = [&](const Item& item) {
      return bins[best.axis].bin_of(item.middle(best.axis)) < best.bin;
    };
    middle = static_cast<std::size_t>(std::partition(at(part.begin), at(part.end), before) -
                                      items.begin());
  }
  return {part_of(items, part.begin, middle), part_of(items, middle, part.end)};
}

}  // namespace

BoxTree::FloatBox::FloatBox(const Bounds& box) {
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    least[axis] = below(box.least[static_cast<Eigen::Index>(axis)]);
    most[axis] = above(box.most[static_cast<Eigen::Index>(axis)]);
  }
}

class BoxTree::Building {
 public:
  explicit Building(std::span<const Bounds> boxes) : items_(boxes.size()) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const FloatBox box(boxes[i]);
      items_[i] = {{box.least, box.most}, static_cast<std::uint32_t>(i)};
    }
  }

  void build(BoxTree& tree) {
    const Part whole = part_of(items_, 0, items_.size());
    tree = items_.size() < kManyItems ? subtree(whole, 0) : on_all_cores(whole);
    tree.nodes_.shrink_to_fit();
  }

 private:
  /// From this number of items on, several threads build the tree.
  static constexpr std::size_t kManyItems = 100'000;
  using Parts = std::vector<Part>;

  /// Splits `whole` into up to four parts. Each step splits the part with the highest cost. A range
  /// that fits a leaf stays whole.
  Parts cut_up(const Part& whole, int level) {
    Parts parts;
    parts.reserve(kWidth);
    parts.push_back(whole);
    while (parts.size() < kWidth && whole.size() > kMostInLeaf) {
      const auto cost = [](const Part& part) {
        return part.size() < 2 ? -1.0 : part.box.area() * static_cast<double>(part.size());
      };
      // A part that is too large for a leaf is split before all parts that fit.
      const auto after = [&](const Part& a, const Part& b) {
        const bool large_a = a.size() > kMostInLeaf, large_b = b.size() > kMostInLeaf;
        return large_a != large_b ? large_b : cost(a) < cost(b);
      };
      const auto next = std::max_element(parts.begin(), parts.end(), after);
      if (next->size() < 2) break;
      const auto cut = halves(items_, *next, level);
      *next = cut[0];
      parts.push_back(cut[1]);
    }
    return parts;
  }

  /// Returns the tree of a range of items.
  BoxTree subtree(const Part& whole, int level) {
    BoxTree tree;
    tree.nodes_.reserve(whole.size() / 2);
    tree.items_.reserve(whole.size());
    node(tree, whole, level);
    return tree;
  }

  /// Appends a node, then its children. Returns the node's index. The items of a subtree are
  /// contiguous.
  std::uint32_t node(BoxTree& tree, const Part& whole, int level) {
    return node(tree, cut_up(whole, level),
                [&](const Part& part, std::size_t) { return node(tree, part, level + 1); });
  }

  /// Appends a node that is already split. `child(part, place)` appends the child of a part
  /// that does not fit a leaf, and returns its index.
  template <class Child>
  std::uint32_t node(BoxTree& tree, const Parts& parts, const Child& child) {
    const auto at = static_cast<std::uint32_t>(tree.nodes_.size());
    tree.nodes_.emplace_back();
    Node made;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      made.least[axis].fill(kInfinity);
      made.most[axis].fill(-kInfinity);
    }
    made.first.fill(0);
    made.count.fill(0);
    for (std::size_t c = 0; c < parts.size(); ++c) {
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        made.least[axis][c] = parts[c].box.least[axis];
        made.most[axis][c] = parts[c].box.most[axis];
      }
      if (parts[c].size() > kMostInLeaf) {
        made.first[c] = child(parts[c], c);
        continue;
      }
      made.first[c] = static_cast<std::uint32_t>(tree.items_.size());
      made.count[c] = static_cast<std::uint32_t>(parts[c].size());
      for (std::size_t i = parts[c].begin; i < parts[c].end; ++i)
        tree.items_.push_back(items_[i].index);
    }
    tree.nodes_[at] = made;
    return at;
  }

  /// Builds the parts of the second level on all cores, then joins them. The tree does not depend
  /// on the number of threads.
  BoxTree on_all_cores(const Part& whole) {
    const Parts top = cut_up(whole, 0);
    std::vector<Parts> below(top.size());
    parallel_for(top.size(), [&](std::size_t i) { below[i] = cut_up(top[i], 1); });
    std::vector<BoxTree> subtrees(top.size() * kWidth);
    parallel_for(subtrees.size(), [&](std::size_t i) {
      const Parts& parts = below[i / kWidth];
      const std::size_t c = i % kWidth;
      if (c < parts.size() && parts[c].size() > kMostInLeaf) subtrees[i] = subtree(parts[c], 2);
    });

    BoxTree tree;
    std::size_t nodes = 1 + top.size();
    for (const BoxTree& part : subtrees) nodes += part.nodes_.size();
    tree.nodes_.reserve(nodes);
    tree.items_.reserve(items_.size());
    node(tree, top, [&](const Part&, std::size_t first) {
      return node(tree, below[first], [&](const Part&, std::size_t second) {
        return append(tree, std::exchange(subtrees[first * kWidth + second], {}));
      });
    });
    return tree;
  }

  /// Appends a tree to another. Returns the index of its first node there.
  static std::uint32_t append(BoxTree& tree, const BoxTree& part) {
    const auto at = static_cast<std::uint32_t>(tree.nodes_.size());
    const auto item = static_cast<std::uint32_t>(tree.items_.size());
    for (Node made : part.nodes_) {
      for (std::size_t c = 0; c < kWidth; ++c)
        if (made.count[c] > 0)
          made.first[c] += item;
        else if (made.first[c] > 0)  // a node. An empty slot has 0, as no child is the first node
          made.first[c] += at;
      tree.nodes_.push_back(made);
    }
    tree.items_.insert(tree.items_.end(), part.items_.begin(), part.items_.end());
    return at;
  }

  std::vector<Item> items_;
};

BoxTree::BoxTree(std::span<const Bounds> boxes) {
  if (boxes.empty()) return;
  for (const Bounds& box : boxes)
    if (!((box.least.array().abs() <= kFarthest).all() &&
          (box.most.array().abs() <= kFarthest).all()))
      throw std::invalid_argument("boxes: must lie within 1e18 m, one does not; check the unit");
  Building(boxes).build(*this);
}

}  // namespace feltwire
