#pragma once
// Vectors and rotations, as values and as the structs of the schema.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/types.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

/// The nearest float32. A finite number beyond the range becomes the largest one: a receiver would
/// drop a datagram with an infinity.
inline float float32(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (std::isinf(value)) return static_cast<float>(value);
  return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}
/// As above, for numbers that a receiver wants above zero: a smaller one than the smallest float32
/// becomes that, not zero.
inline float float32_above_zero(double value) {
  constexpr float kSmallest = std::numeric_limits<float>::denorm_min();
  return value > 0.0 ? std::max(float32(value), kSmallest) : float32(value);
}

inline wire::Vec3d wire_double(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
/// No component becomes the end of the range, as float32() makes it: a force that large is no
/// force.
inline wire::Vec3f wire_float(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
inline wire::Quatd wire_double(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline wire::Quatf wire_float(const Quaternion& q) {
  return {float32(q.w()), float32(q.x()), float32(q.y()), float32(q.z())};
}

inline Vec3 value(const wire::Vec3d& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 value(const wire::Vec3f& v) { return {v.x(), v.y(), v.z()}; }
inline Quaternion value(const wire::Quatd& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Quaternion value(const wire::Quatf& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace feltwire
