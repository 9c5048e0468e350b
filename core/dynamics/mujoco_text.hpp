#pragma once
// Internal to core/dynamics: values in the format of MJCF.

#include <string>

#include "core/scene/validation.hpp"

namespace feltwire::mujoco {

inline std::string text(const Vec3& v) {
  return number_text(v.x()) + " " + number_text(v.y()) + " " + number_text(v.z());
}
inline std::string text(const Quaternion& q) {
  return number_text(q.w()) + " " + number_text(q.x()) + " " + number_text(q.y()) + " " +
         number_text(q.z());
}
inline std::string attribute(const char* name, const std::string& value) {
  return " " + std::string(name) + "=\"" + value + "\"";
}
inline std::string place(const Pose& pose) {
  return attribute("pos", text(pose.position)) + attribute("quat", text(pose.orientation));
}

}  // namespace feltwire::mujoco
