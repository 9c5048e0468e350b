#pragma once

#include <CLI/CLI.hpp>

namespace feltwire {

/// Adds a subcommand for each study. `status` becomes the exit status of a study that judges its
/// results.
void add_torque(CLI::App& app, int& status);
void add_parts(CLI::App& app);
void add_studies(CLI::App& app, int& status);

}  // namespace feltwire
