#pragma once
// Settings in the value of an option: --device gamepad:event5,steer_speed=0.05,map_rotate=0,0,90.

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// A text with settings behind it, separated by commas.
struct SettingsText {
  std::string begin;                  // the text before the first setting
  std::vector<std::string> settings;  // "map_rotate=0,0,90"
};

/// Splits at the commas. A setting begins with the name of an option of `keys` and '='. A part that
/// has no such name and no '=' belongs to the part before it: the commas of 0,0,90 stay.
/// Throws std::invalid_argument for a part with '=' behind a setting that is no setting itself.
SettingsText split_settings(std::string_view text, const CLI::App& keys);

/// Sets the options of `keys`, without their two dashes. `option`: for messages, "--device". Throws
/// std::invalid_argument that names the option, the setting and the remedy.
void read_settings(CLI::App& keys, const std::vector<std::string>& settings,
                   std::string_view option);

/// The settings of `keys` with their descriptions, as --help-all shows options.
std::string settings_help(const CLI::App& keys);

}  // namespace feltwire
