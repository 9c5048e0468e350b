#pragma once
// Settings in the value of an option: --device gamepad:event5,steer_speed=0.05,map_rotate=0,0,90,
// or --mode contact_frame,storage=elastic.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// A text with settings behind it, separated by commas.
struct SettingsText {
  std::string begin;                  // the text before the first setting
  std::vector<std::string> settings;  // "map_rotate=0,0,90"
};

/// The text that may stand before the settings.
enum class SettingsBegin {
  name,  // it has no '='
  file   // it may have '=', as the name of a file
};

/// Splits at the commas. A setting begins with the name of an option of `keys` and '='. A part that
/// has no such name and no '=' belongs to the part before it: the commas of 0,0,90 stay. `option`:
/// for messages, "--device". Throws std::invalid_argument for a part with '=' that is no setting;
/// in a file's name only where it is nearly one. Also for a comma with nothing behind it.
SettingsText split_settings(std::string_view text, const CLI::App& keys, SettingsBegin begin,
                            std::string_view option);

/// The value of a setting in such a text, read without `keys`; nothing: the text has no such part.
std::optional<std::string_view> setting_in(std::string_view text, std::string_view name);

/// Sets the options of `keys`, without their two dashes. `option`: for messages, "--device". Throws
/// std::invalid_argument that names the option, the setting and the remedy.
void read_settings(CLI::App& keys, const std::vector<std::string>& settings,
                   std::string_view option);

/// The settings of `keys` with their descriptions, as --help-all shows options.
std::string settings_help(const CLI::App& keys);

}  // namespace feltwire
