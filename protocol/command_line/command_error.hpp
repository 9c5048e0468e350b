#pragma once
// Errors of a command line as a program prints them: without access tokens. What a program prints
// is often kept.

#include <string>
#include <string_view>

#include "core/base/token_text.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {

/// The text of an error for a terminal: as visible() makes it, and without tokens.
inline std::string printable_error(std::string_view text) { return visible(without_tokens(text)); }

}  // namespace feltwire
