#pragma once
// Errors of a command line as a program prints them: without access tokens. A token is easily given
// in a wrong place, and what a program prints is often kept.

#include <string>
#include <string_view>

#include "core/base/visible_text.hpp"

namespace feltwire {

/// The text with "fw_..." for each word that begins with fw_, as every access token does.
inline std::string without_tokens(std::string_view text) {
  constexpr std::string_view kToken = "fw_", kBefore = " \t\r\n'\"=:,;([",
                             kAfter = " \t\r\n'\",;)]";
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const bool begins = at == 0 || kBefore.find(text[at - 1]) != std::string_view::npos;
    if (begins && text.substr(at).starts_with(kToken)) {
      shown.append(kToken).append("...");
      at = text.find_first_of(kAfter, at);
    } else {
      shown += text[at++];
    }
  }
  return shown;
}

/// The text of an error for a terminal: as visible() makes it, and without tokens.
inline std::string printable_error(std::string_view text) { return visible(without_tokens(text)); }

}  // namespace feltwire
