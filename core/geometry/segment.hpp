#pragma once

#include <algorithm>

#include "core/base/types.hpp"

namespace feltwire {

/// The nearest point of a segment to a given point.
struct NearestOnSegment {
  double share = 0.0;  // position on the segment from its beginning to its end, 0 to 1
  Vec3 point = Vec3::Zero();
};

/// For the segment from a to b, which may be the same point.
inline NearestOnSegment nearest_on_segment(const Vec3& a, const Vec3& b, const Vec3& p) noexcept {
  const Vec3 way = b - a;
  const double square = way.squaredNorm();
  const double share = square > 0.0 ? std::clamp(way.dot(p - a) / square, 0.0, 1.0) : 0.0;
  return {share, a + share * way};
}

}  // namespace feltwire
