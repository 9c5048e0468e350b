#pragma once
// Reads a value of a JSON text without a schema.

#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

/// The text of a member of the document's outermost object, read without a schema. Empty: there is
/// none, or the text is no JSON.
std::optional<std::string> json_text_member(std::string_view json, std::string_view key);

}  // namespace feltwire
