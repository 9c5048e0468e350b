#pragma once

#include "core/base/types.hpp"

namespace feltwire {

/// Returns the vector, shortened to the length `most` if it is longer.
inline Vec3 shortened(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return length > most ? Vec3(v * (most / length)) : v;
}

}  // namespace feltwire
