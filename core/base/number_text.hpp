#pragma once
// The number at the beginning of a text, and the unit behind it.

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

/// The number of characters at the beginning of a text that are a number: 2 of "15ms", 0 of "fast".
inline std::size_t length_of_number(std::string_view text) {
  const bool plus = text.starts_with('+');
  double value = 0.0;
  const char* const begin = text.data() + (plus ? 1 : 0);
  // Digits first: "inf" and "nan" begin words, too.
  const std::size_t sign = text.starts_with('-') || plus ? 1 : 0;
  if (text.size() <= sign || !((text[sign] >= '0' && text[sign] <= '9') || text[sign] == '.'))
    return 0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  return error == std::errc() ? static_cast<std::size_t>(end - text.data()) : 0;
}

/// The factor from one unit to another with the same base: 1e-3 from "mm" to "m", 1e3 from "s" to
/// "ms". Empty for two units without a common base.
inline std::optional<double> unit_factor(std::string_view from, std::string_view to) {
  struct Prefix {
    std::string_view text;
    double factor;
  };
  constexpr std::array<Prefix, 7> kPrefixes = {
      {{"", 1.0}, {"u", 1e-6}, {"m", 1e-3}, {"c", 1e-2}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}}};
  for (const Prefix& one : kPrefixes)
    for (const Prefix& other : kPrefixes) {
      if (!from.starts_with(one.text) || !to.starts_with(other.text)) continue;
      const std::string_view base = from.substr(one.text.size());
      if (!base.empty() && base == to.substr(other.text.size())) return one.factor / other.factor;
    }
  return std::nullopt;
}

/// The number at the beginning of a text, in `unit`: "0.01" of "10mm" in "m". A number without a
/// unit, or with this one, stays as it is written. Spaces in units do not count. Empty if the text
/// has no number, or its unit has another base.
inline std::string number_in_unit(std::string_view text, std::string_view unit) {
  const auto without_spaces = [](std::string_view word) {
    std::string result;
    for (const char c : word)
      if (c != ' ') result += c;
    return result;
  };
  const std::size_t number = length_of_number(text);
  std::string written(text.substr(0, number));
  const std::string from = without_spaces(text.substr(number)), to = without_spaces(unit);
  if (number == 0 || from.empty() || from == to) return written;
  const std::optional<double> factor = unit_factor(from, to);
  if (!factor) return {};
  double value = 0.0;
  const char* const begin = written.data() + (written.starts_with('+') ? 1 : 0);
  std::from_chars(begin, written.data() + written.size(), value);
  std::array<char, 32> result{};
  std::snprintf(result.data(), result.size(), "%.12g", value * *factor);
  return result.data();
}

}  // namespace feltwire
