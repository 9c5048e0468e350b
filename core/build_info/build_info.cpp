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
  constexpr std::string_view kSanitizers = FELTWIRE_SANITIZERS;
  std::string text = program + " " + version() + ", " + compiler() + ", " + build_type();
  if (!kSanitizers.empty()) text.append(", sanitizers ").append(kSanitizers);
  return text;
}

}  // namespace feltwire
