#include "core/build_info/build_info.hpp"

#include <string_view>

#include "core/build_info/commit.hpp"

namespace feltwire {

const std::string& version() {
  static const std::string text = std::string(FELTWIRE_VERSION " ") + generated::kCommit;
  return text;
}

const char* compiler() { return FELTWIRE_COMPILER; }
const char* build_type() { return FELTWIRE_BUILD_TYPE; }

std::string build_info(const std::string& program) {
  // Without sanitizers, FELTWIRE_SANITIZERS is an empty text.
  constexpr bool kSanitized = sizeof(FELTWIRE_SANITIZERS) > 1;
  std::string text = program + " " + version() + ", " + compiler() + ", " + build_type();
  if (std::string_view(FELTWIRE_COMPONENTS) == "client") text += ", client alone";
  if (kSanitized) text += ", sanitizers " FELTWIRE_SANITIZERS;
  return text;
}

}  // namespace feltwire
