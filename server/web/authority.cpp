#include "server/web/authority.hpp"

#include <algorithm>
#include <asio/ip/address.hpp>
#include <charconv>
#include <cstdint>

namespace feltwire::web {
namespace {

constexpr std::size_t kMostHost = 253;  // [bytes] longest host name (RFC 1035)

bool is_decimal(char c) noexcept { return c >= '0' && c <= '9'; }

bool is_port(std::string_view text) noexcept {
  std::uint16_t port = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return !text.empty() && std::ranges::all_of(text, is_decimal) && error == std::errc() &&
         rest == text.data() + text.size() && port > 0;
}

/// Reads an IPv6 address. Empty if the text is not one, or has a zone (%eth0): a zone is valid on
/// one machine only, and no browser sends it.
std::optional<Authority> host_in_brackets(std::string_view text) {
  const bool plain = std::ranges::all_of(text, [](char c) {
    return is_decimal(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') || c == ':' ||
           c == '.';
  });
  std::error_code wrong;
  if (plain) asio::ip::make_address_v6(std::string(text), wrong);
  if (!plain || wrong) return std::nullopt;
  return Authority{in_lower_case(text), true};
}

/// Reads a host name or an IPv4 address. Empty if the text is neither.
std::optional<Authority> plain_host(std::string_view text) {
  if (text.ends_with('.')) text.remove_suffix(1);
  const bool plain = std::ranges::all_of(text, [](char c) {
    return is_decimal(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  });
  if (text.empty() || text.size() > kMostHost || !plain || text.starts_with('.') ||
      text.ends_with('.') || text.find("..") != std::string_view::npos)
    return std::nullopt;
  std::error_code no_address;
  asio::ip::make_address_v4(std::string(text), no_address);
  return Authority{in_lower_case(text), !no_address};
}

}  // namespace

std::string in_lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

std::optional<Authority> parse_authority(std::string_view text) {
  const bool brackets = text.starts_with('[');
  const auto end = brackets ? text.find(']') : text.find(':');
  if (brackets && end == std::string_view::npos) return std::nullopt;
  const std::string_view host = brackets ? text.substr(1, end - 1) : text.substr(0, end);
  std::string_view rest;
  if (end != std::string_view::npos) rest = text.substr(end + (brackets ? 1 : 0));
  if (!rest.empty() && (rest.front() != ':' || !is_port(rest.substr(1)))) return std::nullopt;
  return brackets ? host_in_brackets(host) : plain_host(host);
}

}  // namespace feltwire::web
