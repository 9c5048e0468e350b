#include "core/base/visible_text.hpp"

#include <array>
#include <cstdio>

#include "core/base/utf8.hpp"

namespace feltwire {
namespace {

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
