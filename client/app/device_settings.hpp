#pragma once
// The settings in --device KIND:NAME,map_scale=2: of the device, and of a simulated hand.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/option_values.hpp"
#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// The value of --device in parts.
struct DeviceText {
  std::string kind, name;
  std::string arguments;              // of a plugin, with the ':' before them
  std::vector<std::string> settings;  // "map_scale=2"

  /// KIND, KIND:NAME, or plugin:FILE.so:ARGUMENTS: without the settings.
  std::string device() const;
};

/// A device for a command that runs no session.
struct BareDevice {
  const Driver* driver = nullptr;
  DeviceRequest request;
};

/// Adds the settings to `keys`. They are written to `values`, `task` (of the simulated hand) and
/// `options`.
void add_device_settings(CLI::App& keys, OptionValues& values, HandTask& task,
                         ClientOptions& options);

/// Splits KIND:NAME,KEY=VALUE,...; KIND:KEY=VALUE,... where the device has no name; and
/// plugin:FILE.so,KEY=VALUE,...:ARGUMENTS. `keys`: with the settings. Throws std::invalid_argument
/// for an unknown setting.
DeviceText split_device(std::string_view text, const CLI::App& keys);

/// Reads the settings of values.device.kind, which keeps KIND or KIND:NAME. `keys`, `values`,
/// `task`: as in add_device_settings(). Throws std::invalid_argument.
void read_device_settings(CLI::App& keys, OptionValues& values, const HandTask& task);

/// The value of --device with its files in this folder. Throws std::invalid_argument.
std::string device_in_folder(const std::string& value, const std::filesystem::path& folder,
                             const CLI::App& keys);

/// Reads a value of --device whose only settings are the plant and the firmware. Throws
/// std::invalid_argument, also for another setting.
BareDevice bare_device(const std::string& device);

/// The options of earlier versions that are settings of --device now.
Renamed renamed_device_options(const CLI::App& keys);

}  // namespace feltwire
