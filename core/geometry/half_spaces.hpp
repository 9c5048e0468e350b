#pragma once
// The point of a corner of space that is nearest to another: what up to three active constraints
// leave of a movement.

#include <array>
#include <cstddef>
#include <span>

#include "core/base/types.hpp"

namespace feltwire {

/// The side n . x >= offset of a plane.
struct HalfSpace {
  Vec3 normal = Vec3::UnitZ();  // unit
  double offset = 0.0;          // [m]
  double height(const Vec3& x) const { return normal.dot(x) - offset; }
};

struct Nearest {
  Vec3 point = Vec3::Zero();
  std::array<std::size_t, 3> active{};  // indices of the planes it lies on
  int count = 0;
  bool found = false;  // false: no point is in all half spaces, or rounding hides it
};

/// The point of all half spaces that is nearest to `goal`, right to `tolerance` [m]. One active
/// plane more a round, as in Goldfarb & Idnani's dual method, with the sets of four so small that
/// all of their subsets are tried.
Nearest nearest_in(std::span<const HalfSpace> spaces, const Vec3& goal, double tolerance) noexcept;

}  // namespace feltwire
