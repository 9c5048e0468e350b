#pragma once
// Vectors and poses as the structs of the C interface have them.

#include "core/base/types.hpp"

namespace feltwire {

inline Vec3 vector(const double (&from)[3]) { return {from[0], from[1], from[2]}; }
/// From w, x, y, z. It need not be of length 1.
inline Quaternion quaternion(const double (&from)[4]) {
  return {from[0], from[1], from[2], from[3]};
}

inline void put(const Vec3& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}
inline void put(const Quaternion& from, double (&to)[4]) {
  to[0] = from.w();
  to[1] = from.x();
  to[2] = from.y();
  to[3] = from.z();
}
inline void put(const Pose& from, double (&position)[3], double (&orientation)[4]) {
  put(from.position, position);
  put(from.orientation, orientation);
}

}  // namespace feltwire
