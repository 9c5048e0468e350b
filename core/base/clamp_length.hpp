#pragma once

#include "core/base/numeric.hpp"

namespace feltwire {

/// Returns the vector, shortened to the length `most` if it is longer.
inline Vec3 clamp_length(const Vec3& v, double most) noexcept {
  const double size = length(v);
  return size > most ? Vec3(v * (most / size)) : v;
}

}  // namespace feltwire
