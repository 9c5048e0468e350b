#include <array>

#include "protocol/control.hpp"

namespace feltwire::control {

const char* name(RefusalCode code) {
  static constexpr std::array<const char*, 13> names = {
      "malformed",     "unknown_scene", "unknown_session", "bad_device", "bad_parameters",
      "full",          "shutting_down", "unauthenticated", "forbidden",  "too_many",
      "not_supported", "bad_scene",     "unknown_tool"};
  const auto i = static_cast<std::size_t>(code);
  return i < names.size() ? names[i] : "unknown";
}

}  // namespace feltwire::control
