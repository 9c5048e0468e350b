#pragma once
// Text that somebody else wrote, made safe to print.

#include <string>
#include <string_view>

namespace feltwire {

/// The text on one line, without anything that a terminal obeys or that misleads a reader: control
/// characters (C0, DEL, C1), line and paragraph separators, and characters that turn the direction
/// of text or take no room are written as \x1b (below U+0100) or \u{202e}; bytes that are not UTF-8
/// as \xff. All else stays as it is, a backslash too.
///
/// Whatever a program prints or logs that came over the network or from a file goes through here.
std::string visible(std::string_view text);

/// The same for text of several lines: each '\n' stays.
std::string visible_lines(std::string_view text);

}  // namespace feltwire
