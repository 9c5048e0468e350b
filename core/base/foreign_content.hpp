#pragma once
// Recognizes what stands in a file instead of what its name promises.

#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

/// If the bytes are none of a file that is meant, but something that takes its place now and then:
/// "is a pointer of Git LFS, not the file itself; fetch it with: git lfs pull". It knows pointers
/// of Git LFS and git-annex, web pages, packed files and text in UTF-16. Quotes nothing of the
/// file. Empty: none of these.
std::optional<std::string> foreign_content(std::string_view bytes);

/// The text behind its byte order mark of UTF-8, if it has one.
std::string_view without_byte_order_mark(std::string_view text);

}  // namespace feltwire
