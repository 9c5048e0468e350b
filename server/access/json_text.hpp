#pragma once
// Builds JSON as text, from the inside out. A server uses no trees of nlohmann's, because their
// destructor allocates, and ends the program if there is no memory.

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
/// The shortest digits that read back as the same number; null: it is not finite.
std::string number(double value);

/// Objects and lists of values that are already JSON text, one in each line.
using Member = std::pair<std::string_view, std::string>;
std::string object(const std::vector<Member>& members);
std::string list(const std::vector<std::string>& entries);

}  // namespace feltwire::json_text
