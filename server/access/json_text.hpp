#pragma once
// JSON as text, made from the inside out. A server makes no trees of nlohmann's: their destructor
// allocates, and ends the program where there is no memory.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace feltwire::json_text {

/// A JSON string in quotes. Bytes that are not UTF-8 are replaced.
std::string text(std::string_view text);
inline std::string number(std::uint64_t value) { return std::to_string(value); }
inline std::string number(std::int64_t value) { return std::to_string(value); }

/// Objects and lists of values that are JSON text already, one a line.
using Member = std::pair<std::string_view, std::string>;
std::string object(const std::vector<Member>& members);
std::string list(const std::vector<std::string>& entries);

}  // namespace feltwire::json_text
