#pragma once
// Errors of a command line as a program prints them: without access tokens. What a program prints
// is often kept.

#include <string>
#include <string_view>

#include "core/base/token_text.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {

/// The text of an error for a terminal: as visible() makes it, and without tokens. If the process
/// has used up its file descriptors, the remedy follows, since any call may be the first to fail.
inline std::string printable_error(std::string_view text) {
  const char* const remedy = text.find("Too many open files") == std::string_view::npos
                                 ? ""
                                 : "; raise the limit of open files (ulimit -n)";
  return visible(without_tokens(text)) + remedy;
}

}  // namespace feltwire
