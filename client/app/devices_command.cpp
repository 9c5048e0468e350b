#include "client/app/devices_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/devices/drivers.hpp"
#include "client/devices/plugged_in.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

/// Prints for each driver that needs a maker's library or service what it found. True: something is
/// missing although a device that needs it is plugged in.
bool show_libraries(const std::vector<PluggedIn>& devices) {
  bool missed = false;
  for (const Driver& driver : drivers()) {
    if (driver.library == nullptr) continue;
    std::string line;
    try {
      line = std::string(driver.kind) + ": " + driver.library();
    } catch (const std::runtime_error& error) {
      line = error.what();
      missed |= std::any_of(devices.begin(), devices.end(),
                            [&](const PluggedIn& one) { return one.kind == driver.kind; });
    }
    std::printf("%s\n", visible(line).c_str());
  }
  return missed;
}

}  // namespace

int devices_command(int argc, char** argv) {
  CLI::App app("Lists the connected haptic devices, and their problems with remedies",
               "feltwire-client devices");
  Machine machine;
  std::string root = "/";
  app.add_option("--root", root, "Folder with sys, dev and proc")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "feltwire-client devices: %s; see --help\n",
                 visible(error.what()).c_str());
    return 2;
  }
  machine.root = root;
  const std::vector<PluggedIn> devices = plugged_in(machine);
  std::printf("Plugged in\n%s\nMakers' libraries and services\n",
              visible_lines(text(devices)).c_str());
  const bool missed = show_libraries(devices);
  const bool complaints = std::any_of(devices.begin(), devices.end(),
                                      [](const PluggedIn& one) { return !one.complaints.empty(); });
  return missed || complaints ? 1 : 0;
}

}  // namespace feltwire
