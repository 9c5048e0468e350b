#pragma once
// Numbers as text, the same in every locale where no format of printf is given.

#include <array>
#include <charconv>
#include <cstdio>
#include <string>

namespace feltwire {

/// The shortest text that reads back as the same number.
inline std::string shortest_text(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// The text that printf would print, such as "1.5 mm" of "%.3g mm"; at most 95 characters.
template <class... Numbers>
std::string printed(const char* format, Numbers... numbers) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);
  return text.data();
}

}  // namespace feltwire
