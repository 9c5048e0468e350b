#pragma once
// The number at the beginning of a text.

#include <charconv>
#include <cstddef>
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

}  // namespace feltwire
