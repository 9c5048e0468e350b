#include "core/geometry/box_tree.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace feltwire {
namespace {

constexpr unsigned kMostInLeaf = 4;
constexpr unsigned kMaxDepth = 32;  // beyond it only leaves too large are cut
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float below(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafter(f, -kInfinity);
}
float above(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, kInfinity);
}

/// One for the whole program: making it costs more than most trees.
RTCDevice device() {
  struct Release {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  };
  static const std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> shared(
      rtcNewDevice(nullptr));
  return shared.get();
}

/// What Embree's builder makes, before it is laid out flat.
struct Built {
  unsigned count = 0;  // 0: an inner node, else a leaf's things
  std::array<std::uint32_t, kMostInLeaf> things{};
  std::array<Built*, kMostInLeaf> children{};
  std::array<RTCBounds, kMostInLeaf> bounds{};
};

Built* allocate(RTCThreadLocalAllocator allocator) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(Built), alignof(Built))) Built;
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return allocate(allocator);
}

void set_children(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i)
    static_cast<Built*>(node)->children[i] = static_cast<Built*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) static_cast<Built*>(node)->bounds[i] = *bounds[i];
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* things,
                  std::size_t count, void*) {
  Built* leaf = allocate(allocator);
  leaf->count = static_cast<unsigned>(count);
  for (std::size_t i = 0; i < count; ++i) leaf->things[i] = things[i].primID;
  return leaf;
}

}  // namespace

BoxTree::FloatBox::FloatBox(const Bounds& box) {
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    least[axis] = below(box.least[static_cast<Eigen::Index>(axis)]);
    most[axis] = above(box.most[static_cast<Eigen::Index>(axis)]);
  }
}

/// Lays the built tree out, parents before children, the things of a subtree side by side.
struct BoxTree::Building {
  BoxTree& tree;

  std::uint32_t node(const Built& built) {
    const auto at = static_cast<std::uint32_t>(tree.nodes_.size());
    tree.nodes_.emplace_back();
    Node made;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      made.least[axis].fill(kInfinity);
      made.most[axis].fill(-kInfinity);
    }
    made.first.fill(0);
    made.count.fill(0);
    for (std::size_t c = 0; c < kWidth; ++c) {
      const Built* child = built.children[c];
      if (child == nullptr) continue;
      const RTCBounds& b = built.bounds[c];
      made.least[0][c] = b.lower_x;
      made.least[1][c] = b.lower_y;
      made.least[2][c] = b.lower_z;
      made.most[0][c] = b.upper_x;
      made.most[1][c] = b.upper_y;
      made.most[2][c] = b.upper_z;
      made.count[c] = child->count;
      made.first[c] = child->count > 0 ? leaf(*child) : node(*child);
    }
    tree.nodes_[at] = made;
    return at;
  }

  std::uint32_t leaf(const Built& built) {
    const auto at = static_cast<std::uint32_t>(tree.things_.size());
    tree.things_.insert(tree.things_.end(), built.things.begin(),
                        built.things.begin() + built.count);
    return at;
  }
};

BoxTree::BoxTree(std::span<const Bounds> boxes) {
  if (boxes.empty()) return;
  std::vector<RTCBuildPrimitive> things(boxes.size());
  RTCBounds whole{kInfinity, kInfinity, kInfinity, 0.0f, -kInfinity, -kInfinity, -kInfinity, 0.0f};
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const FloatBox b(boxes[i]);
    things[i] = {b.least[0], b.least[1], b.least[2], 0,
                 b.most[0],  b.most[1],  b.most[2],  static_cast<unsigned>(i)};
    whole.lower_x = std::min(whole.lower_x, b.least[0]);
    whole.lower_y = std::min(whole.lower_y, b.least[1]);
    whole.lower_z = std::min(whole.lower_z, b.least[2]);
    whole.upper_x = std::max(whole.upper_x, b.most[0]);
    whole.upper_y = std::max(whole.upper_y, b.most[1]);
    whole.upper_z = std::max(whole.upper_z, b.most[2]);
  }

  using Handle = std::unique_ptr<std::remove_pointer_t<RTCBVH>, decltype(&rtcReleaseBVH)>;
  const Handle bvh(rtcNewBVH(device()), &rtcReleaseBVH);
  RTCBuildArguments how = rtcDefaultBuildArguments();
  how.maxBranchingFactor = kWidth;
  how.maxDepth = kMaxDepth;
  how.sahBlockSize = kMostInLeaf;
  how.maxLeafSize = kMostInLeaf;
  how.bvh = bvh.get();
  how.primitives = things.data();
  how.primitiveCount = things.size();
  how.primitiveArrayCapacity = things.size();
  how.createNode = create_node;
  how.setNodeChildren = set_children;
  how.setNodeBounds = set_bounds;
  how.createLeaf = create_leaf;
  const auto* root = static_cast<const Built*>(rtcBuildBVH(&how));
  if (root == nullptr)
    throw std::runtime_error("a tree over " + std::to_string(boxes.size()) +
                             " boxes cannot be built, Embree's error " +
                             std::to_string(rtcGetDeviceError(device())) + "; free some memory");

  Built single;  // above a root that is a leaf
  if (root->count > 0) {
    single.children[0] = const_cast<Built*>(root);
    single.bounds[0] = whole;
    root = &single;
  }
  nodes_.reserve(boxes.size() / 2);
  things_.reserve(boxes.size());
  Building{*this}.node(*root);
  nodes_.shrink_to_fit();
}

}  // namespace feltwire
