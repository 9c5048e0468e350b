#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace feltwire {

/// Adds a subcommand for each study. `status` becomes the exit status of a study that judges its
/// results.
void add_advise(CLI::App& app);
void add_torque(CLI::App& app, int& status);
void add_convex_parts(CLI::App& app);
void add_compare(CLI::App& app);
void add_extremes(CLI::App& app, int& status);
void add_trade(CLI::App& app);
void add_studies(CLI::App& app, int& status);

/// A study: it runs into a folder, writes its files there and returns the text that is printed,
/// before `files` says where those are. Returns its subcommand, to which options of its own may be
/// added.
CLI::App* add_study(CLI::App& app, const std::string& name, const std::string& folder,
                    const std::string& question, const std::string& footer,
                    const std::string& files,
                    const std::function<std::string(const std::string& out)>& run);

void add_out(CLI::App& command, std::string& out);
/// The line that ends what a study prints.
std::string placed(const std::string& what, const std::string& out);

}  // namespace feltwire
