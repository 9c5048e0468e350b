#pragma once

#include <spdlog/formatter.h>

#include <memory>
#include <string>

namespace feltwire {

/// spdlog's usual line, with visible() text in it: text from a client, a scene or a token file is
/// shown safely (core/base/visible_text.hpp).
std::unique_ptr<spdlog::formatter> visible_log_format();

/// Sends the log of the program `name` to stderr in that format, from `level` on (one of spdlog's).
void open_log(const std::string& name, const std::string& level);

}  // namespace feltwire
