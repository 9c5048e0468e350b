#pragma once
// Where a simulated hand means to be when a person leads it: never further from the hand than its
// arm shall press.

#include <algorithm>

#include "core/base/types.hpp"

namespace feltwire {

/// [m/s] of where a hand means to be that was pushed away.
inline constexpr double kYielding = 0.05;

/// As long as `most` at most, in the same direction.
inline Vec3 shortened(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return length > most ? Vec3(v * (most / length)) : v;
}

/// `lead` is the way from the hand to where it means to be [m, or rad of a wrist]. Returns it after
/// the aim was moved by `way`: within `reach`, or as far as it was before, less `yielded`. Where
/// the hand was pushed away the aim stays, for an aim that moved with the hand would damp nothing.
inline Vec3 led(const Vec3& lead, const Vec3& way, double reach, double yielded) noexcept {
  return shortened(lead + way, std::max(reach, lead.norm() - yielded));
}

}  // namespace feltwire
