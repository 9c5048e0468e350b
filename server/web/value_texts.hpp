#pragma once
// Values of the page's messages as JSON.

#include <string>

#include "core/base/types.hpp"
#include "server/access/json_text.hpp"

namespace feltwire::web {

inline std::string flag_text(bool value) { return value ? "true" : "false"; }
inline std::string vector_text(const Vec3& v) {
  return "[" + json_text::number(v.x()) + "," + json_text::number(v.y()) + "," +
         json_text::number(v.z()) + "]";
}

}  // namespace feltwire::web
