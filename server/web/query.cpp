#include "server/web/query.hpp"

#include <algorithm>
#include <charconv>

namespace feltwire {
namespace {

std::optional<std::string> unescaped(std::string_view text) {
  constexpr std::size_t kDigits = 2;
  constexpr int kHexadecimal = 16;
  std::string plain;
  while (!text.empty()) {
    if (text.front() != '%') {
      plain += text.front();
      text.remove_prefix(1);
      continue;
    }
    const std::string_view digits = text.substr(1, kDigits);
    unsigned char value = 0;
    const char* end = digits.data() + digits.size();
    const auto [read_to, error] = std::from_chars(digits.data(), end, value, kHexadecimal);
    if (digits.size() != kDigits || error != std::errc() || read_to != end) return std::nullopt;
    plain += static_cast<char>(value);
    text.remove_prefix(1 + kDigits);
  }
  return plain;
}

}  // namespace

std::optional<std::string> query_value(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view field = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), field.size() + 1));
    const std::size_t equals = field.find('=');
    if (field.substr(0, equals) == name && equals != std::string_view::npos)
      return unescaped(field.substr(equals + 1));
  }
  return std::nullopt;
}

}  // namespace feltwire
