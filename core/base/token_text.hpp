#pragma once
// Access tokens in texts. A token is easily given in the place of a name, and names are sent, shown
// and logged.

#include <cstddef>
#include <string>
#include <string_view>

namespace feltwire {

/// How every access token begins: fw_<id>_<secret>, with an id of 12 hex digits.
inline constexpr std::string_view kTokenPrefix = "fw_";

/// Whether a token begins at `text[at]`: its prefix, id and the '_' behind it. Precondition: at is
/// at most the length of the text.
inline bool token_begins(std::string_view text, std::size_t at) {
  constexpr std::size_t kId = 12;
  const std::string_view rest = text.substr(at);
  if (!rest.starts_with(kTokenPrefix) || rest.size() <= kTokenPrefix.size() + kId) return false;
  const std::string_view id = rest.substr(kTokenPrefix.size(), kId);
  return id.find_first_not_of("0123456789abcdef") == std::string_view::npos &&
         rest[kTokenPrefix.size() + kId] == '_';
}

/// Whether there is an access token anywhere in the text. Bytes of a message count as text.
inline bool has_token(std::string_view text) {
  for (std::size_t at = text.find(kTokenPrefix); at != std::string_view::npos;
       at = text.find(kTokenPrefix, at + 1))
    if (token_begins(text, at)) return true;
  return false;
}

/// The text with "fw_..." for each access token, and for each word that begins as one does.
inline std::string without_tokens(std::string_view text) {
  constexpr std::string_view kBefore = " \t\r\n'\"=:,;([#-", kAfter = " \t\r\n'\",;)]";
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const bool word = at == 0 || kBefore.find(text[at - 1]) != std::string_view::npos;
    if (token_begins(text, at) || (word && text.substr(at).starts_with(kTokenPrefix))) {
      shown.append(kTokenPrefix).append("...");
      at = text.find_first_of(kAfter, at);
    } else {
      shown += text[at++];
    }
  }
  return shown;
}

}  // namespace feltwire
