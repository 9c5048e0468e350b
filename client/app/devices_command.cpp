#include "client/app/devices_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/app/device_settings.hpp"
#include "client/drivers/drivers.hpp"
#include "client/input_devices/usb_scan.hpp"
#include "client/run/device_check.hpp"
#include "core/base/visible_text.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

/// Prints for each driver whether the maker's library or service was found. Returns true if the
/// library of a connected device is missing.
bool show_libraries(const std::vector<ConnectedDevice>& devices) {
  bool missed = false;
  for (const Driver& driver : drivers()) {
    if (driver.library == nullptr) continue;
    std::string line;
    try {
      line = std::string(driver.kind) + ": " + driver.library();
    } catch (const std::runtime_error& error) {
      line = error.what();
      missed |= std::any_of(devices.begin(), devices.end(),
                            [&](const ConnectedDevice& one) { return one.kind == driver.kind; });
    }
    std::printf("%s\n", visible(line).c_str());
  }
  return missed;
}

int failed_command(const char* why, int status) {
  std::fprintf(stderr, "feltwire-client devices: %s\n", printable_error(why).c_str());
  return status;
}

/// Runs the device for `span` [s] without a force, and prints its measured rate and jitter. Returns
/// the exit status.
int show_rate(const std::string& words, double span, double rate) {
  try {
    const BareDevice bare = bare_device(words);
    const OpenedDevice opened = bare.driver->open(bare.request);
    const std::vector<CheckResult> results = judge(watch_ticks(*opened.device, span, rate));
    std::printf("%s for %.1f s, without a force\n%s", visible(opened.device->spec().name).c_str(),
                span, table(results).c_str());
    return worst(results) == Verdict::fail ? 1 : 0;
  } catch (const std::invalid_argument& error) {
    return failed_command(error.what(), 2);
  } catch (const std::exception& error) {
    return failed_command(error.what(), 1);
  }
}

}  // namespace

int devices_command(int argc, char** argv) {
  CLI::App app("Lists the connected haptic devices, their problems and the remedies",
               "feltwire-client devices");
  Machine machine;
  std::string root = "/", rated;
  bool specs = false;
  double span = 5.0, rate = 1000.0;
  app.add_option("--root", root, "Folder that contains sys, dev and proc")->capture_default_str();
  CLI::Option* asked = app.add_option(
      "--rate", rated,
      "KIND or KIND:NAME Open this device, and measure its rate and jitter without a force. A "
      "Falcon may need falcon:firmware=FILE");
  app.add_option("--seconds", span, "[s] Length of the measurement of --rate")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 3600.0))
      ->needs(asked);
  app.add_option("--hz", rate,
                 "[Hz] Rate of the measurement of --rate, unless the device sets the rate")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 20000.0))
      ->needs(asked);
  app.add_flag("--specs", specs,
               "Print the built-in specifications, with the source of each number, and exit")
      ->excludes(asked);
  try {
    check_words(app, argc, argv, {{"firmware", "--rate falcon:firmware=FILE"}});
    parse_arguments(app, argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "feltwire-client devices: %s; see --help\n",
                 printable_error(error.what() + advice(error, app)).c_str());
    return 2;
  } catch (const std::invalid_argument& error) {
    return failed_command(error.what(), 2);
  }
  if (specs) {
    for (const SourcedSpec& described : sourced_builtin_devices())
      std::printf("%s\n", spec_table(described).c_str());
    return 0;
  }
  if (!rated.empty()) return show_rate(rated, span, rate);
  machine.root = root;
  const std::vector<ConnectedDevice> devices = scan_usb(machine);
  std::printf("Plugged in\n%s\nMakers' libraries and services\n",
              visible_lines(text(devices)).c_str());
  const bool missed = show_libraries(devices);
  const bool complaints =
      std::any_of(devices.begin(), devices.end(),
                  [](const ConnectedDevice& one) { return !one.complaints.empty(); });
  return missed || complaints ? 1 : 0;
}

}  // namespace feltwire
