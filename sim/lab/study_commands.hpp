#pragma once

#include <CLI/CLI.hpp>

namespace feltwire {

/// Adds a subcommand a study. `status` becomes the exit status of one that judges what it measured.
void add_torque(CLI::App& app, int& status);
void add_parts(CLI::App& app);
void add_studies(CLI::App& app, int& status);

}  // namespace feltwire
