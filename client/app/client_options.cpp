#include "client/app/client_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string_view>

#include "client/app/add_options.hpp"
#include "client/app/device_settings.hpp"
#include "client/app/option_values.hpp"
#include "client/app/rival_options.hpp"
#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/short_help.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "protocol/session/profiles.hpp"

namespace feltwire {
namespace {

constexpr int kUsageError = 2;

ShortHelp short_help() {
  return {{{"config", "FILE.json with options, for example of a device (docs/devices.md)"},
           {"connect", "HOST:PORT of the server's control port; IPv6 as [::1]:PORT"},
           {"list", "List the server's scenes and exit"},
           {"check", "Test if this machine and the network can run a session, and exit"},
           {"scene", "Name of the scene to join"},
           {"tool", "Name of the tool to hold. Default: the scene's first tool"},
           {"role", "operator, pointer (a small hand) or observer (watches only)"},
           {"device",
            "simulated, replay:FILE.csv, haply, forcedimension, openhaptics,\n"
            "falcon, hapi:PORT, gamepad, spacemouse, plugin:FILE.so, and their\n"
            "settings: simulated:path=slide,depth=0.01,center=0,0,0\n"
            "(path: press, slide, orbit, figure-eight or taps)"},
           {"spec", "Specification of the device: a built-in name or FILE.json"},
           {"list-specs", "Print the built-in specifications and exit"},
           {"duration", "[s] Length of the run. 0: run until it is stopped"},
           {"report", "FILE.json for the results of the run"},
           {"record", "FILE.csv or FILE.mcap for a recording of every tick"},
           {"fingerprint-file", "FILE with the fingerprint of the server to trust"},
           {"ca", "FILE (PEM) of trusted authorities, in place of a fingerprint"},
           {"token-file", "FILE with your token. Or set FELTWIRE_TOKEN to the token"},
           {"link", "Emulate a network: wifi, or delay=25,jitter=5,loss=10 (--help-all)"},
           {"mode", "Bounding method (docs/bounding.md)"},
           {"rate", "[Hz] Rate of the servo loop, unless the device sets the rate"},
           {"max-force", "[N] Largest force on the hand"},
           {"lead", "[s] Lead the robot from this time on (docs/teleoperation.md)"}},
          R"(
All options, and the syntax of --device and --link: feltwire-client --help-all, docs/devices.md.
Commands, each with its own --help:
  admin      show and change the state of a running server (docs/admin.md)
  devices    list the connected devices and their problems (docs/devices.md)
  identify   measure a device's damping, friction and mass (docs/devices.md)
Example, with a server on this machine:
  export FELTWIRE_FINGERPRINT_FILE=~/.local/state/feltwire/fingerprint
  export FELTWIRE_TOKEN_FILE=~/.local/state/feltwire/local.token
  feltwire-client --connect localhost:6720 --scene room --device simulated:path=taps --duration 5)"};
}

/// The value of --device with its files in this folder.
std::string device_in_folder(const std::string& value, const std::filesystem::path& folder) {
  const DeviceText given = split_device(value);
  const DriverChoice chosen = chosen_driver(given.device);
  std::vector<std::string> files;
  if (chosen.driver->file != nullptr && !chosen.name.empty())
    files.push_back(chosen.driver->file(chosen.name));
  constexpr std::string_view kPlant = "plant=";
  for (const std::string& setting : given.settings)
    if (setting.starts_with(kPlant)) files.push_back(setting.substr(kPlant.size()));
  std::string text = value;
  for (const std::string& file : files)
    if (const std::size_t at = text.find(file); !file.empty() && at != std::string::npos)
      text.replace(at, file.size(), (folder / file).string());
  return text;
}

/// The options of earlier versions that have another spelling now.
Renamed renamed_options() {
  Renamed renamed = renamed_device_options();
  renamed.push_back({"fixed", "--changes none"});
  return renamed;
}

/// The files of a configuration file lie in its folder, also those in --spec and --device.
std::string file_value(std::string_view option, const std::string& value,
                       const std::filesystem::path& folder) {
  constexpr std::array<std::string_view, 10> kFiles = {
      "ca",  "certificate", "fingerprint-file", "firmware",   "flight-recorder",
      "key", "record",      "report",           "token-file", "view"};
  if (option == "spec") return value.ends_with(".json") ? (folder / value).string() : value;
  if (option == "device") return device_in_folder(value, folder);
  const bool named = std::ranges::count(kFiles, option) > 0;
  const bool off = option == "flight-recorder" && value == "off";
  return named && !off ? (folder / value).string() : value;
}

/// With `error_text`, the environment is not read, nothing is printed, and the error goes there.
std::variant<ClientOptions, int> parse(int argc, const char* const* argv, std::string* error_text,
                                       bool has_server = true) {
  ClientOptions options;
  SessionParameters& parameters = options.parameters;
  HandTask task;
  OptionValues values;
  values.has_server = has_server;

  CLI::App app{
      "feltwire-client: connects a haptic device (real, simulated or replayed) to a scene of a "
      "server."};
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "feltwire-client: " + visible(error.what() + advice(error, *failed)) + "; see --help\n";
  });
  add_helps(app);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-client"); },
      "Print version, commit, compiler and build type, and exit");
  add_options(app, values, options);

  const std::vector<std::string> ending = {"list", "list-specs", "check"};
  const Variables variables{.program = "client",
                            .shared = credential_variables(),
                            .ending = ending,
                            .renamed = renamed_options()};
  const bool reads_environment = error_text == nullptr;
  const auto refuse = [error_text](const std::string& text) {
    if (error_text != nullptr)
      *error_text = text;
    else
      std::cerr << "feltwire-client: " << visible(text) << "\n";
    return kUsageError;
  };
  ConfigFile config;
  try {
    check_words(app, argc, argv, variables.renamed);
    if (reads_environment) read_environment(app, argc, argv, variables, client_rivals());
    if (const auto file = given_value(app, argc, argv, "config", reads_environment)) {
      std::vector<std::string> command_line = ending;
      command_line.emplace_back("config");
      config =
          read_config(app, read_text(*file), *file, command_line, file_value, variables.renamed);
      // The token of the environment has no option that would override the file.
      if (const char* const token = std::getenv("FELTWIRE_TOKEN");
          reads_environment && token != nullptr && *token != '\0')
        std::erase_if(config.entries,
                      [](const ConfigEntry& entry) { return entry.option == "token-file"; });
    }
    const auto words =
        words_with_config(app, argc, argv, config, client_rivals(), reads_environment);
    parse_words(app, words);
    if (!values.profile.empty()) {
      apply_profile(network_profile(values.profile), values, parameters);
      parse_words(app, words);
    }
    read_device_settings(values, task, options);
    to_client_options(values, task, options);
  } catch (const CLI::ParseError& error) {
    if (error_text == nullptr && (error.get_exit_code() == 0 || config.entries.empty()))
      return exit_with(app, error, short_help()) == 0 ? 0 : kUsageError;
    return refuse(config.located(error.what()) + advice(error, app));
  } catch (const FileError& error) {
    return refuse(error.what());
  } catch (const std::invalid_argument& error) {
    return refuse(config.located(error.what()));
  }
  return options;
}

}  // namespace

std::variant<ClientOptions, int> parse_options(int argc, char** argv) {
  return parse(argc, argv, nullptr);
}

ClientOptions options_of(const std::vector<std::string>& words, bool has_server) {
  std::vector<const char*> argv{"feltwire-client"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::string error;
  auto parsed = parse(static_cast<int>(argv.size()), argv.data(), &error, has_server);
  if (!error.empty()) throw std::invalid_argument(error);
  return std::get<ClientOptions>(std::move(parsed));
}

}  // namespace feltwire
