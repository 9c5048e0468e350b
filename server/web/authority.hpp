#pragma once
// The host that a request names (Host), and its port (RFC 9110, 7.2; RFC 3986, 3.2).

#include <optional>
#include <string>
#include <string_view>

namespace feltwire::web {

/// Returns the host of "HOST" or "HOST:PORT", in lower case, without brackets and without one dot
/// at its end. HOST is a name, an IPv4 address, or an IPv6 address in brackets. `is_address`: it is
/// one of the two. Empty for any other text: user names, zones, a port that is no number from 1 to
/// 65535, something behind the brackets.
struct Authority {
  std::string host;
  bool is_address = false;
};
std::optional<Authority> parse_authority(std::string_view text);

/// The text with its letters of ASCII in lower case.
std::string in_lower_case(std::string_view text);

}  // namespace feltwire::web
