#include "core/mesh/box_tree.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace feltwire {
namespace {

constexpr unsigned kMostInLeaf = 4;
/// From here on boxes are put in the order of a space-filling curve (Embree's Morton builder),
/// which takes a quarter of the time; on so many, questions take no longer, or a fifth where they
/// are uneven. Fewer are cut by the surface area heuristic.
constexpr std::size_t kMany = std::size_t{1} << 18;
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

[[noreturn]] void fail_to_build(std::size_t boxes, RTCError error) {
  throw std::runtime_error("a tree over " + std::to_string(boxes) +
                           " boxes cannot be built, Embree's error " + std::to_string(error) +
                           (error == RTC_ERROR_OUT_OF_MEMORY ? " (no memory)" : "") +
                           "; free some memory, or raise the process's limit (ulimit -v)");
}

/// One for the whole program: making it costs more than most trees. Null where there is no memory
/// for it; who asks later may get one.
RTCDevice device() {
  struct Release {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  };
  static std::mutex making;
  static std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> shared;
  const std::lock_guard lock(making);
  if (shared == nullptr) shared.reset(rtcNewDevice(nullptr));
  return shared.get();
}

/// A leaf or an inner node as Embree's builder makes it, before the tree is laid out flat.
struct Built {
  unsigned count = 0;  // of a leaf's things; 0: a node
};
struct BuiltLeaf : Built {
  std::array<std::uint32_t, kMostInLeaf> things{};
};
struct BuiltNode : Built {
  std::array<const Built*, kMostInLeaf> children{};
  std::array<RTCBounds, kMostInLeaf> bounds{};
};

template <class Made>
Made* allocate(RTCThreadLocalAllocator allocator) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(Made), alignof(Made))) Made;
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return static_cast<Built*>(allocate<BuiltNode>(allocator));
}

BuiltNode& node_of(void* built) { return *static_cast<BuiltNode*>(static_cast<Built*>(built)); }

void set_children(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i)
    node_of(node).children[i] = static_cast<const Built*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) node_of(node).bounds[i] = *bounds[i];
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* things,
                  std::size_t count, void*) {
  auto* leaf = allocate<BuiltLeaf>(allocator);
  leaf->count = static_cast<unsigned>(count);
  for (std::size_t i = 0; i < count; ++i) leaf->things[i] = things[i].primID;
  return static_cast<Built*>(leaf);
}

}  // namespace

BoxTree::FloatBox::FloatBox(const Bounds& box) {
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    least[axis] = below(box.least[static_cast<Eigen::Index>(axis)]);
    most[axis] = above(box.most[static_cast<Eigen::Index>(axis)]);
  }
}

struct BoxTree::Building {
  /// In float, rounded outwards; `whole` holds them all.
  static void fill(std::span<const Bounds> boxes, std::vector<RTCBuildPrimitive>& things,
                   RTCBounds& whole) {
    whole = {kInfinity, kInfinity, kInfinity, 0.0f, -kInfinity, -kInfinity, -kInfinity, 0.0f};
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
  }

  /// Null where Embree cannot.
  static const Built* build(RTCBVH bvh, std::vector<RTCBuildPrimitive>& things,
                            RTCBuildQuality quality) {
    RTCBuildArguments how = rtcDefaultBuildArguments();
    how.buildQuality = quality;
    how.maxBranchingFactor = kWidth;
    how.maxDepth = kMaxDepth;
    how.sahBlockSize = kMostInLeaf;
    how.minLeafSize = quality == RTC_BUILD_QUALITY_LOW ? kMostInLeaf : 1;
    how.maxLeafSize = kMostInLeaf;
    how.bvh = bvh;
    how.primitives = things.data();
    how.primitiveCount = things.size();
    how.primitiveArrayCapacity = things.size();
    how.createNode = create_node;
    how.setNodeChildren = set_children;
    how.setNodeBounds = set_bounds;
    how.createLeaf = create_leaf;
    return static_cast<const Built*>(rtcBuildBVH(&how));
  }

  /// Lays the built tree out, parents before children, the things of a subtree side by side.
  std::uint32_t node(const BuiltNode& built) {
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
      made.first[c] = child->count > 0 ? leaf(static_cast<const BuiltLeaf&>(*child))
                                       : node(static_cast<const BuiltNode&>(*child));
    }
    tree.nodes_[at] = made;
    return at;
  }

  std::uint32_t leaf(const BuiltLeaf& built) {
    const auto at = static_cast<std::uint32_t>(tree.things_.size());
    tree.things_.insert(tree.things_.end(), built.things.begin(),
                        built.things.begin() + built.count);
    return at;
  }

  BoxTree& tree;
};

BoxTree::BoxTree(std::span<const Bounds> boxes) {
  if (boxes.empty()) return;
  for (const Bounds& box : boxes)
    if (!((box.least.array().abs() <= kFarthest).all() &&
          (box.most.array().abs() <= kFarthest).all()))
      throw std::invalid_argument("boxes: must lie within 1e18 m, one does not; check the unit");
  using Handle = std::unique_ptr<std::remove_pointer_t<RTCBVH>, decltype(&rtcReleaseBVH)>;
  RTCDevice const embree = device();
  if (embree == nullptr) fail_to_build(boxes.size(), rtcGetDeviceError(nullptr));
  const Handle bvh(rtcNewBVH(embree), &rtcReleaseBVH);
  if (bvh == nullptr) fail_to_build(boxes.size(), rtcGetDeviceError(embree));
  RTCBounds whole{};
  std::vector<RTCBuildPrimitive> things(boxes.size());
  const Built* root = nullptr;
  if (boxes.size() >= kMany) {
    Building::fill(boxes, things, whole);
    root = Building::build(bvh.get(), things, RTC_BUILD_QUALITY_LOW);
  }
  if (root == nullptr) {
    Building::fill(boxes, things, whole);
    root = Building::build(bvh.get(), things, RTC_BUILD_QUALITY_MEDIUM);
  }
  if (root == nullptr) fail_to_build(boxes.size(), rtcGetDeviceError(embree));

  BuiltNode single;  // above a root that is a leaf
  single.children[0] = root;
  single.bounds[0] = whole;
  nodes_.reserve(boxes.size() / 2);
  things_.reserve(boxes.size());
  Building{*this}.node(root->count > 0 ? single : static_cast<const BuiltNode&>(*root));
  nodes_.shrink_to_fit();
}

}  // namespace feltwire
