#include "client/app/client_options.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string_view>

#include "client/app/add_options.hpp"
#include "client/app/device_settings.hpp"
#include "client/app/option_values.hpp"
#include "client/app/rival_options.hpp"
#include "client/app/session_settings.hpp"
#include "core/base/file_error.hpp"
#include "core/base/token_text.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/settings.hpp"
#include "protocol/command_line/short_help.hpp"
#include "protocol/command_line/suggestion.hpp"

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
           {"duration", "[s] Length of the run. 0: run until it is stopped"},
           {"report", "FILE.json for the results of the run"},
           {"record", "FILE.csv or FILE.mcap for a recording of every tick"},
           {"fingerprint-file", "FILE with the fingerprint of the server to trust"},
           {"ca", "FILE (PEM) of trusted authorities, in place of a fingerprint"},
           {"token-file", "FILE with your token. Or set FELTWIRE_TOKEN to the token"},
           {"link", "Emulate a network: wifi, or delay=25,jitter=5,loss=10 (--help-all)"},
           {"mode", "Bounding method, and settings: contact_frame,storage=elastic"},
           {"traffic", "Network to the server, and settings: wan,packet_rate=50 (--help-all)"},
           {"rate", "[Hz] Rate of the servo loop, unless the device sets the rate"},
           {"max-force", "[N] Largest force on the hand"},
           {"lead", "[s] Lead the robot from this time on (docs/teleoperation.md)"}},
          R"(
All options and settings: feltwire-client --help-all, docs/devices.md.
Commands, each with its own --help:
  admin      show and change the state of a running server (docs/admin.md)
  devices    list the connected devices, or the built-in specifications (docs/devices.md)
  identify   measure a device's damping, friction and mass (docs/devices.md)
Example, with a server on this machine:
  export FELTWIRE_FINGERPRINT_FILE=~/.local/state/feltwire/fingerprint
  export FELTWIRE_TOKEN_FILE=~/.local/state/feltwire/local.token
  feltwire-client --connect localhost:6720 --scene room --device simulated:path=taps --duration 5)"};
}

/// The settings in the values of options.
struct OptionSettings {
  CLI::App device{""}, mode{""}, traffic{""};

  OptionSettings(OptionValues& values, HandTask& task, ClientOptions& options) {
    add_device_settings(device, values, task, options);
    add_mode_settings(mode, values, options);
    add_traffic_settings(traffic, values, options.parameters);
  }
};

/// The text of --help-all behind the options.
std::string long_footer(const OptionSettings& settings) {
  return "\nSettings of --mode (docs/bounding.md):" + settings_help(settings.mode) +
         "\nSettings of --traffic (docs/network.md):" + settings_help(settings.traffic) +
         "\nSettings of --device (docs/devices.md):" + settings_help(settings.device) + "\n" +
         link_help() +
         "\nCommands, each with its own --help:\n"
         "  admin      show and change the state of a running server (docs/admin.md)\n"
         "  devices    list the connected devices and their problems, or the built-in\n"
         "             specifications (docs/devices.md)\n"
         "  identify   measure a device's damping, friction and mass (docs/devices.md)";
}

/// The options of earlier versions that have another spelling now.
Renamed renamed_options(const OptionSettings& settings) {
  Renamed renamed = renamed_device_options(settings.device);
  const Renamed session = renamed_session_options(settings.mode, settings.traffic);
  renamed.insert(renamed.end(), session.begin(), session.end());
  renamed.push_back({"fixed", "--changes none"});
  renamed.push_back({"list-specs", "feltwire-client devices --specs"});
  return renamed;
}

/// The files of a configuration file lie in its folder, also those in --spec and --device.
FileValue file_value(const CLI::App& device) {
  const FileValue file =
      files_in_folder({"ca", "certificate", "fingerprint-file", "flight-recorder", "key", "record",
                       "report", "spec", "token-file", "view"});
  return [&device, file](std::string_view option, const std::string& value,
                         const std::filesystem::path& folder) {
    if (option == "device") return device_in_folder(value, folder, device);
    const bool no_file = (option == "flight-recorder" && value == "off") ||
                         (option == "spec" && !value.ends_with(".json"));
    return no_file ? value : file(option, value, folder);
  };
}

/// With `error_text`, the environment is not read, nothing is printed, and the error goes there.
std::variant<ClientOptions, int> parse(int argc, const char* const* argv, std::string* error_text,
                                       bool has_server = true) {
  ClientOptions options;
  HandTask task;
  OptionValues values;
  values.has_server = has_server;

  CLI::App app{
      "feltwire-client: connects a haptic device (real, simulated or replayed) to a scene of a "
      "server."};
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "feltwire-client: " + printable_error(error.what() + advice(error, *failed)) +
           "; see --help\n";
  });
  add_helps(app);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-client"); },
      "Print version, commit, compiler and build type, and exit");
  add_options(app, values, options);
  OptionSettings settings(values, task, options);
  app.footer(long_footer(settings));

  const std::vector<std::string> ending = {"list", "check"};
  const Variables variables{.program = "client",
                            .shared = credential_variables(),
                            .ending = ending,
                            .renamed = renamed_options(settings)};
  const bool reads_environment = error_text == nullptr;
  const auto refuse = [error_text](const std::string& text) {
    if (error_text != nullptr)
      *error_text = without_tokens(text);
    else
      std::cerr << "feltwire-client: " << printable_error(text) << "\n";
    return kUsageError;
  };
  ConfigFile config;
  try {
    check_words(app, argc, argv, variables.renamed);
    if (reads_environment) read_environment(app, argc, argv, variables, client_rivals());
    config = given_config(app, argc, argv, ending, file_value(settings.device), variables.renamed,
                          reads_environment);
    const auto words =
        words_with_config(app, argc, argv, config, client_rivals(), reads_environment);
    parse_words(app, words);
    read_mode_settings(settings.mode, values);
    read_traffic_settings(settings.traffic, values, options.parameters);
    read_device_settings(settings.device, values, task);
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
