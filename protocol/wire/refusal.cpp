#include <array>
#include <string_view>

#include "core/base/enum_names.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire::control {

const char* name(RefusalCode code) {
  static constexpr std::array<const char*, 15> names = {
      "malformed",     "unknown_scene", "unknown_session", "bad_device", "bad_parameters",
      "full",          "shutting_down", "unauthenticated", "forbidden",  "too_many",
      "not_supported", "bad_scene",     "unknown_tool",    "failed",     "bad_ticket"};
  return enum_name(names, code);
}

std::string shortened(const std::string& text, std::size_t most) {
  constexpr std::string_view kCut = " [...]";
  constexpr unsigned kContinues = 0x80, kContinuesMask = 0xc0;
  constexpr std::size_t kLongest = 4;  // [bytes] longest character in UTF-8
  if (text.size() <= most) return text;
  std::size_t end = most - kCut.size();
  // Move the cut back to the first byte of the character that it would split. A text that is not
  // UTF-8 may be cut anywhere.
  std::size_t start = end;
  while (start > 0 && end - start < kLongest &&
         (static_cast<unsigned char>(text[start]) & kContinuesMask) == kContinues)
    --start;
  if (end - start < kLongest) end = start;
  return text.substr(0, end).append(kCut);
}

}  // namespace feltwire::control
