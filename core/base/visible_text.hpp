#pragma once
// Makes text from outside safe to print.

#include <string>
#include <string_view>

namespace feltwire {

/// The text on one line, without anything that a terminal obeys or that misleads a reader: control
/// characters (C0, DEL, C1), line and paragraph separators, and characters that turn the direction
/// of text or take no room are written as \x1b (below U+0100) or \u{202e}; bytes that are not UTF-8
/// as \xff. Everything else is unchanged, also a backslash.
///
/// Programs pass every text from the network or from a file through this before they print or log
/// it.
std::string visible(std::string_view text);

/// Like visible(), for text of several lines: it keeps each '\n'.
std::string visible_lines(std::string_view text);

}  // namespace feltwire
