#pragma once
// The walls that push a tool.

#include <array>
#include <cmath>

#include "core/base/types.hpp"

namespace feltwire {

/// The normals of the contacts whose forces add up to one elastic force. World frame.
struct ContactNormals {
  static constexpr int kMost = 3;  // directions in space
  /// Towards the free side.
  std::array<Vec3, kMost> unit{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int count = 0;

  /// Adds a unit normal that stands out of the plane, or off the line, of those before it. Any
  /// other is left out: its force then counts for the others. False: it was left out.
  bool add(const Vec3& normal) noexcept {
    constexpr double kStandsOut = 0.2;  // the sine of 11.5 degrees
    if (count == kMost) return false;
    const Vec3 across = count == 2 ? unit[0].cross(unit[1]).normalized() : Vec3::Zero();
    const double off = count == 0   ? 1.0
                       : count == 1 ? unit[0].cross(normal).norm()
                                    : std::abs(across.dot(normal));
    if (!(off > kStandsOut)) return false;
    unit[static_cast<std::size_t>(count++)] = normal;
    return true;
  }
};

}  // namespace feltwire
