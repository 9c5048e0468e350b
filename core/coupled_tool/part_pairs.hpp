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
};

struct PartPairs {
  static constexpr std::size_t kMost = 128;
  std::array<PartPair, kMost> pairs;  // in the order of object, tool part, solid part
  std::size_t count = 0;
  std::size_t turn = 0;  // the pair whose `away` may follow the force in the next step
  bool known = false;
  /// All pairs that are not here were at least `free` [m] apart with the tool at `from`.
  double free = 0.0;
  Pose from;
};

}  // namespace feltwire
