#pragma once
// The head of an HTTP/1.1 request, as far as the live page needs it (RFC 9112, RFC 6455 4.2). It
// has no socket. It is strict: it refuses everything that no browser sends.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

struct HttpHeader {
  std::string name;   // in lower case
  std::string value;  // without space at either end
};

struct HttpRequest {
  std::string method;  // "GET"
  std::string path;    // begins with '/'; never has %-escapes, ".." or a query
  std::string query;   // after '?', unchanged; may be empty
  std::vector<HttpHeader> headers;

  /// The value of the one header of this name (lower case); null: there is none, or more than one.
  const std::string* header(std::string_view name) const noexcept;
};

/// Whether a path begins with '/' and has only letters, digits and the marks "/-_.", without ".."
/// and "//". The files of the page have such names, so paths with escapes are refused.
bool is_plain_path(std::string_view path) noexcept;

/// [bytes] A longer head is refused.
inline constexpr std::size_t kMaxHttpHead = 8192;

/// The length of the head at the beginning of `received`, with its empty line. Empty: it has not
/// ended yet.
std::optional<std::size_t> http_head_length(std::string_view received) noexcept;

/// Reads a head with its empty line. Empty if it is malformed, if it has a body, or if it is longer
/// than kMaxHttpHead.
std::optional<HttpRequest> parse_http_head(std::string_view head);

/// Whether a list header (`Connection: keep-alive, Upgrade`) has this member, in any case.
/// `member` in lower case.
bool has_member(std::string_view list, std::string_view member) noexcept;

/// The text of Sec-WebSocket-Accept for a key (RFC 6455, 4.2.2); empty if the key is not 16 bytes
/// in base64.
std::optional<std::string> websocket_accept(std::string_view key);

}  // namespace feltwire
