#pragma once
// Vectors and rotations, as values and as the structs of the schema.

#include "core/base/types.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

inline wire::Vec3d wire_double(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline wire::Vec3f wire_float(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
inline wire::Quatd wire_double(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline wire::Quatf wire_float(const Quaternion& q) {
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
          static_cast<float>(q.z())};
}

inline Vec3 value(const wire::Vec3d& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 value(const wire::Vec3f& v) { return {v.x(), v.y(), v.z()}; }
inline Quaternion value(const wire::Quatd& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Quaternion value(const wire::Quatf& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace feltwire
