#pragma once
// The intended place of a simulated hand that a person leads. Its distance from the hand is
// limited, and so is the force of the arm.

#include <algorithm>

#include "core/base/clamp_length.hpp"

namespace feltwire {

/// [m/s] speed with which the intended place yields to a push.
inline constexpr double kYielding = 0.05;

/// Moves the intended place by `way`. `lead` is the vector from the hand to the intended place [m,
/// or rad for a wrist]. Returns the new vector. Its length is at most `reach`, or the old length
/// less `yielded` if that is more. If the hand is pushed away, the intended place stays; an
/// intended place that moved with the hand would damp nothing.
inline Vec3 led(const Vec3& lead, const Vec3& way, double reach, double yielded) noexcept {
  return clamp_length(lead + way, std::max(reach, lead.norm() - yielded));
}

}  // namespace feltwire
