#pragma once
// The settings in --device KIND:NAME,map_scale=2: of the device, and of a simulated hand.

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/option_values.hpp"
#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// The value of --device in parts.
struct DeviceText {
  std::string device;                 // KIND or KIND:NAME
  std::vector<std::string> settings;  // "map_scale=2"
};

/// Adds the settings to `keys`. They are written to `values`, `task` (of the simulated hand) and
/// `options`.
void add_device_settings(CLI::App& keys, OptionValues& values, HandTask& task,
                         ClientOptions& options);

/// Splits KIND:NAME,KEY=VALUE,...; KIND:KEY=VALUE,... where the device has no name; and
/// plugin:FILE.so,KEY=VALUE,...:ARGUMENTS. Throws std::invalid_argument for an unknown setting.
DeviceText split_device(std::string_view text);

/// Reads the settings of values.device, which keeps KIND or KIND:NAME. Throws
/// std::invalid_argument.
void read_device_settings(OptionValues& values, HandTask& task, ClientOptions& options);

/// The settings with their descriptions, for --help-all.
std::string device_settings_help();

/// The options of earlier versions that are settings of --device now.
Renamed renamed_device_options();

}  // namespace feltwire
