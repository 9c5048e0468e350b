#pragma once

#include <spdlog/formatter.h>

#include <memory>
#include <string>

namespace feltwire {

/// spdlog's usual line, with visible() text in it: text from a client, a scene or a token file is
/// shown safely (core/base/visible_text.hpp).
std::unique_ptr<spdlog::formatter> visible_log_format();

/// Each line is one JSON object: {"time":"2026-11-30T01:45:46.123456Z","level":"info",
/// "program":"feltwire-server","text":"..."}. The time is UTC.
std::unique_ptr<spdlog::formatter> json_log_format();

/// Sends the log of the program `name` to stderr, from `level` on (one of spdlog's). `format`:
/// "text" or "json".
void open_log(const std::string& name, const std::string& level,
              const std::string& format = "text");

}  // namespace feltwire
