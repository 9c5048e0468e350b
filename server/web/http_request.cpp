#include "server/web/http_request.hpp"

#include <openssl/evp.h>
#include <openssl/sha.h>

#include <algorithm>
#include <array>

#include "server/web/authority.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kMostHeaders = 64;

bool is_letter_or_digit(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// Returns whether the text is a token of HTTP (RFC 9110, 5.6.2).
bool is_token(std::string_view text) noexcept {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_letter_or_digit(c) || kMarks.find(c) != std::string_view::npos;
  });
}

/// Returns whether the text has only printable ASCII characters and tabs.
bool is_plain(std::string_view text) noexcept {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= ' ' && c <= '~') || c == '\t'; });
}

std::string_view trimmed(std::string_view text) noexcept {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool read_first_line(std::string_view line, HttpRequest& request) {
  const auto first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return false;
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  if (!is_token(method) || line.substr(last + 1) != "HTTP/1.1") return false;
  const auto question = target.find('?');
  const std::string_view path = target.substr(0, question);
  if (!is_plain_path(path) || target.find(' ') != std::string_view::npos || !is_plain(target))
    return false;
  request.method = method;
  request.path = path;
  if (question != std::string_view::npos) request.query = target.substr(question + 1);
  return true;
}

bool read_header(std::string_view line, HttpRequest& request) {
  const auto colon = line.find(':');
  if (colon == std::string_view::npos || request.headers.size() == kMostHeaders) return false;
  const std::string_view name = line.substr(0, colon), value = trimmed(line.substr(colon + 1));
  if (!is_token(name) || !is_plain(value)) return false;
  request.headers.push_back({web::in_lower_case(name), std::string(value)});
  return true;
}

/// Returns whether the request has a body. The server would read a body as the next request.
bool has_body(const HttpRequest& request) {
  return std::any_of(request.headers.begin(), request.headers.end(), [](const HttpHeader& header) {
    return header.name == "transfer-encoding" ||
           (header.name == "content-length" && header.value != "0");
  });
}

}  // namespace

const std::string* HttpRequest::header(std::string_view name) const noexcept {
  const std::string* found = nullptr;
  for (const HttpHeader& header : headers) {
    if (header.name != name) continue;
    if (found != nullptr) return nullptr;
    found = &header.value;
  }
  return found;
}

bool is_plain_path(std::string_view path) noexcept {
  constexpr std::string_view kMarks = "/-_.";
  return path.starts_with('/') && path.find("..") == std::string_view::npos &&
         path.find("//") == std::string_view::npos &&
         std::all_of(path.begin(), path.end(), [&](char c) {
           return is_letter_or_digit(c) || kMarks.find(c) != std::string_view::npos;
         });
}

std::optional<std::size_t> http_head_length(std::string_view received) noexcept {
  const auto end = received.find("\r\n\r\n");
  if (end == std::string_view::npos) return std::nullopt;
  return end + 4;
}

std::optional<HttpRequest> parse_http_head(std::string_view head) {
  if (head.size() > kMaxHttpHead || !head.ends_with("\r\n\r\n")) return std::nullopt;
  head.remove_suffix(2);
  HttpRequest request;
  for (bool first = true; !head.empty(); first = false) {
    const auto end = head.find("\r\n");
    const std::string_view line = head.substr(0, end);
    if (!(first ? read_first_line(line, request) : read_header(line, request))) return std::nullopt;
    head.remove_prefix(end + 2);
  }
  if (request.method.empty() || has_body(request)) return std::nullopt;
  return request;
}

bool has_member(std::string_view list, std::string_view member) noexcept {
  while (!list.empty()) {
    const auto comma = list.find(',');
    const std::string_view entry = trimmed(list.substr(0, comma));
    if (entry.size() == member.size() &&
        std::equal(entry.begin(), entry.end(), member.begin(), [](char a, char b) {
          return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
        }))
      return true;
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  return false;
}

std::optional<std::string> websocket_accept(std::string_view key) {
  constexpr std::size_t kKeyLength = 24;  // length of 16 bytes in base64
  constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  if (key.size() != kKeyLength || !key.ends_with("==") ||
      !std::all_of(key.begin(), key.end() - 2,
                   [](char c) { return is_letter_or_digit(c) || c == '+' || c == '/'; }))
    return std::nullopt;
  const std::string text = std::string(key) + std::string(kGuid);
  std::array<unsigned char, SHA_DIGEST_LENGTH> hash{};
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  std::array<unsigned char, 4 * ((SHA_DIGEST_LENGTH + 2) / 3) + 1> encoded{};
  const int length = EVP_EncodeBlock(encoded.data(), hash.data(), SHA_DIGEST_LENGTH);
  return std::string(reinterpret_cast<const char*>(encoded.data()),
                     static_cast<std::size_t>(length));
}

}  // namespace feltwire
