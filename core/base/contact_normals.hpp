#pragma once
// The normals of the walls that push a tool.

#include <array>
#include <cmath>

#include "core/base/types.hpp"

namespace feltwire {

/// The normals of the contacts whose forces add up to one elastic force. World frame.
struct ContactNormals {
  static constexpr int kMost = 3;  // independent directions in space
  /// Unit normals towards the free side.
  std::array<Vec3, kMost> unit{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int count = 0;

  /// Adds a unit normal that is not in the plane, or on the line, of those before it. Any other is
  /// left out, and its force counts for the others. False: it was left out.
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
