#pragma once
// The nearest point to a goal within up to three half spaces: the movement that the active
// constraints allow.

#include <array>
#include <cstddef>
#include <span>

#include "core/base/types.hpp"
#include "core/base/work_limit.hpp"

namespace feltwire {

/// The half space n . x >= offset.
struct HalfSpace {
  Vec3 normal = Vec3::UnitZ();  // unit
  double offset = 0.0;          // [m]
  double height(const Vec3& x) const { return normal.dot(x) - offset; }
};

struct NearestPoint {
  Vec3 point = Vec3::Zero();
  std::array<std::size_t, 3> active{};  // indices of the planes on which the point lies
  int count = 0;
  bool found = false;  // false: no point is in all half spaces, or rounding hides it
};

/// Returns the point of all half spaces that is nearest to `goal`, correct to `tolerance` [m]. Each
/// round adds an active plane, as in Goldfarb & Idnani's dual method. The sets of four are so small
/// that all of their subsets are tried. Where `work` is cut off, nothing is found.
NearestPoint nearest_in(std::span<const HalfSpace> spaces, const Vec3& goal, double tolerance,
                        WorkLimit* work = nullptr) noexcept;

}  // namespace feltwire
