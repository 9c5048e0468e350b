#pragma once
// Characters of a text in UTF-8.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace feltwire {

using CodePoint = std::uint32_t;

/// A UTF-8 character and its size [bytes]. The size is 0 if the first byte begins no character.
struct Character {
  CodePoint code = 0;
  std::size_t size = 0;
};

/// Returns the first character of a text that is not empty. By table 3-7 of the Unicode standard, a
/// valid character has the shortest form, is no surrogate, and is at most U+10FFFF.
Character first_character(std::string_view text);

/// Returns whether the whole text is UTF-8.
bool is_utf8(std::string_view text);

}  // namespace feltwire
