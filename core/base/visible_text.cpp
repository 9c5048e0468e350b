#include "core/base/visible_text.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

namespace feltwire {
namespace {

using CodePoint = std::uint32_t;

/// A UTF-8 character and its size [bytes]. The size is 0 if the first byte begins no character.
struct Character {
  CodePoint code = 0;
  std::size_t size = 0;
};

/// Returns the first character of a text. By table 3-7 of the Unicode standard, a valid character
/// has the shortest form, is no surrogate, and is at most U+10FFFF.
Character first_character(std::string_view text) {
  constexpr CodePoint kFirstSurrogate = 0xD800, kLastSurrogate = 0xDFFF, kLast = 0x10FFFF;
  // Least code of each size, indexed by size.
  constexpr std::array<CodePoint, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC0 || lead > 0xF7 || text.size() < size) return {};
  CodePoint code = lead & (0x7Fu >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  const bool surrogate = code >= kFirstSurrogate && code <= kLastSurrogate;
  if (code < kLeast[size] || code > kLast || surrogate) return {};
  return {code, size};
}

bool within(CodePoint code, CodePoint first, CodePoint last) {
  return code >= first && code <= last;
}

/// Returns true if the character controls a terminal or is invisible.
bool hidden(CodePoint code) {
  constexpr CodePoint kSoftHyphen = 0xAD, kArabicMark = 0x61C, kByteOrderMark = 0xFEFF;
  return code < 0x20 || within(code, 0x7F, 0x9F) || code == kSoftHyphen || code == kArabicMark ||
         within(code, 0x200B, 0x200F) ||    // zero-width characters, direction marks
         within(code, 0x2028, 0x202E) ||    // line separators, direction embeddings, overrides
         within(code, 0x2060, 0x206F) ||    // word joiners, direction isolates
         within(code, 0xFFF9, 0xFFFB) ||    // annotations
         within(code, 0xE0000, 0xE0FFF) ||  // tags, variation selectors
         within(code, 0x180B, 0x180E) || code == kByteOrderMark;
}

void append_code(std::string& out, const char* format, unsigned code) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), format, code);
  out += text.data();
}

std::string shown(std::string_view text, bool lines) {
  constexpr CodePoint kOneByte = 0x100;
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_character(text);
    if (c.size == 0)
      append_code(out, "\\x%02x", static_cast<unsigned char>(text.front()));
    else if (hidden(c.code) && !(lines && c.code == '\n'))
      append_code(out, c.code < kOneByte ? "\\x%02x" : "\\u{%x}", c.code);
    else
      out += text.substr(0, c.size);
    text.remove_prefix(c.size == 0 ? 1 : c.size);
  }
  return out;
}

}  // namespace

std::string visible(std::string_view text) { return shown(text, false); }
std::string visible_lines(std::string_view text) { return shown(text, true); }

}  // namespace feltwire
