#pragma once
// Numbers as people and programs write them with commas between them.

#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>

namespace feltwire {

/// The number that `text` is as a whole. None: it is not one, not finite, or larger than `most`.
inline std::optional<double> number_of(std::string_view text, double most) noexcept {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !(std::abs(value) <= most)) return std::nullopt;
  return value;
}

/// "1,2,3" of exactly as many numbers; false: it is not. Then some values may be set.
inline bool numbers_of(std::string_view text, std::span<double> values, double most) noexcept {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t end = text.find(',');
    if ((end == std::string_view::npos) != (i + 1 == values.size())) return false;
    const auto value = number_of(text.substr(0, end), most);
    if (!value) return false;
    values[i] = *value;
    if (end != std::string_view::npos) text.remove_prefix(end + 1);
  }
  return true;
}

}  // namespace feltwire
