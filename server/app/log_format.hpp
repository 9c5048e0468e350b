#pragma once

#include <spdlog/formatter.h>

#include <memory>

namespace feltwire {

/// spdlog's usual line, with visible() text in it: what a log line quotes may come from a client,
/// a scene or a token file, and is shown, not obeyed (core/base/visible_text.hpp).
std::unique_ptr<spdlog::formatter> visible_log_format();

}  // namespace feltwire
