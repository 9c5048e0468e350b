#pragma once
// The end of every `feltwire-server COMMAND ...` that does one thing and ends.

#include <CLI/CLI.hpp>
#include <functional>

namespace feltwire {

/// Exit codes of feltwire-server: the command line or a file is wrong; the work could not be done.
inline constexpr int kBadUsage = 2, kCannotRun = 1;

/// Parses the command line (argv[0] is the command) and calls `work`. Returns the exit status,
/// after it has printed an error in one line that begins with the name of `app`.
int run_subcommand(CLI::App& app, int argc, char** argv, const std::function<void()>& work);

}  // namespace feltwire
