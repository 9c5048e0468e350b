#pragma once
// Values of a command line that CLI11 reads as something else than a user means.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace feltwire {

/// Makes every option of `app` and of its subcommands refuse an empty value, a whole number that is
/// not decimal (CLI11 reads 010 as 8, and 0x10 as 16) or beyond its type (CLI11 reads 2^64 as
/// 2^64 - 1, and -1 as that), and a hexadecimal number. Options with a range also refuse nan, which
/// CLI11 finds in every range. Call it after all options were added.
void refuse_misread_values(CLI::App& app);

/// Throws CLI::ValidationError for a word "--record=". CLI11 would take the next word for its
/// value.
void refuse_missing_values(const CLI::App& app, const std::vector<std::string>& words);

/// Parses the command line of a program, with the checks above. Throws CLI::ParseError.
void parse_arguments(CLI::App& app, int argc, const char* const* argv);

/// Parses the command line of a program that has no other source of options. Returns its exit
/// status if it must end: 0 after --help, 2 after an error. That is printed with the name of `app`.
std::optional<int> ends_at_arguments(CLI::App& app, int argc, const char* const* argv);

}  // namespace feltwire
