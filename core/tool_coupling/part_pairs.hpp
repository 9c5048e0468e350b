#pragma once
// A tool of polygons remembers the pairs of convex parts that are near each other.

#include <array>
#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

/// A convex part of the tool near one of a solid.
struct PartPair {
  std::uint32_t object = 0, tool_part = 0, solid_part = 0;
  bool thickened = false;    // `away` is known
  Vec3 away = Vec3::Zero();  // unit, object frame: from the solid to the tool, when they were apart
  double reach = 0.0;        // [m] largest away . v over the solid's part
  double gap = 0.0;          // [m] lower bound of the distance when it was looked at
  bool overlaps = false;     // a point of both is known, but they may have moved since
  Vec3 shared = Vec3::Zero();  // [m] object frame: this point
};

/// The push of one pair, at a pose of the tool.
struct PairPush {
  bool known = false;
  PartPair pair;  // and its direction at that time
  Pose tool;
  double cubes = 0.0;         // [m^6] V
  Vec3 slope = Vec3::Zero();  // [m^5] gradient of V, object frame
};

struct PartPairs {
  static constexpr std::size_t kMost = 128;
  std::array<PartPair, kMost> pairs;  // in the order of object, tool part, solid part
  std::size_t count = 0;
  std::size_t turn = 0;  // the pair whose `away` may have followed the force in the last step
  PairPush push;         // of the next one, where the contact was last computed
  bool known = false;
  /// All pairs that are not here were at least `free` [m] apart with the tool at `from`.
  double free = 0.0;
  Pose from;

  std::size_t next_turn() const { return count == 0 ? 0 : (turn + 1) % count; }
};

}  // namespace feltwire
