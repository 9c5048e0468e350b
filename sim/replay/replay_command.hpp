#pragma once

#include <CLI/CLI.hpp>
#include <ostream>

namespace feltwire {

/// Adds the subcommand `replay` (docs/recording.md), which writes to `out`. `status` becomes the
/// exit status: 0 if all was computed again to the same bits, else 1.
void add_replay(CLI::App& app, std::ostream& out, int& status);

}  // namespace feltwire
