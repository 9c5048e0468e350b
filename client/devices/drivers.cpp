#include "client/devices/drivers.hpp"

#include <array>
#include <stdexcept>
#include <utility>

#include "client/devices/falcon.hpp"
#include "client/devices/force_dimension.hpp"
#include "client/devices/hapi.hpp"
#include "client/devices/haply.hpp"
#include "client/devices/open_haptics.hpp"
#include "client/devices/plugin_device.hpp"
#include "client/devices/replay.hpp"
#include "client/devices/simulated_device.hpp"
#include "client/devices/steered_device.hpp"
#include "core/base/choice.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace {

using Name = Driver::Name;

OpenedDevice open_simulated(const DeviceRequest& request) {
  SourcedSpec described = requested_spec(request.spec, "simulated");
  std::vector<std::string> notes = assumptions(described);
  return {std::make_unique<SimulatedDevice>(
              SimulatedHandOptions{.spec = std::move(described.spec),
                                   .hand = request.held ? Hand{} : kNoHand,
                                   .task = request.task,
                                   .wrist = request.wrist,
                                   .own_center = request.own_center,
                                   .own_normal = request.own_normal,
                                   .leads_from = request.leads_from,
                                   .presses_at = request.presses_at}),
          std::move(notes)};
}

OpenedDevice open_replay(const DeviceRequest& request) {
  const SourcedSpec described = requested_spec(request.spec, "simulated");
  return {make_replay_device(request.name, described.spec, request.leads_from),
          assumptions(described)};
}

constexpr std::array kDrivers = {
    Driver{.kind = "simulated",
           .takes_name = Name::none,
           .name = "",
           .names_file = false,
           .summary = "a simulated hand",
           .spec = "simulated",
           .open = open_simulated,
           .library = nullptr,
           .held_by_person = false,
           .buttons = 1},
    Driver{.kind = "replay",
           .takes_name = Name::required,
           .name = "FILE.csv",
           .names_file = true,
           .summary = "a recording; columns t,x,y,z and optionally qw,qx,qy,qz",
           .spec = "simulated",
           .open = open_replay,
           .library = nullptr,
           .held_by_person = false,
           .gives_force = false},
    Driver{.kind = "forcedimension",
           .takes_name = Name::optional,
           .name = "NUMBER",
           .names_file = false,
           .summary = "omega, delta, sigma, lambda, Falcon, with the maker's SDK",
           .spec = "omega.7",
           .open = open_force_dimension,
           .library = force_dimension_library,
           .buttons = 8,
           .deadman_button = 2,
           .clutch_button = 1},
    Driver{.kind = "openhaptics",
           .takes_name = Name::optional,
           .name = "NAME",
           .names_file = false,
           .summary = "Touch, Touch X, Premium, with the maker's OpenHaptics",
           .spec = "touch",
           .open = open_haptics,
           .library = open_haptics_library,
           .buttons = 4,
           .deadman_button = 1,
           .clutch_button = 2},
    Driver{.kind = "haply",
           .takes_name = Name::optional,
           .name = "ID@PORT",
           .names_file = false,
           .summary = "Inverse3, Inverse3x, Minverse, with the maker's service",
           .spec = "inverse3",
           .open = open_haply,
           .library = haply_usual_service,
           .buttons = 3,
           .deadman_button = 1,
           .clutch_button = 2},
    Driver{.kind = "falcon",
           .takes_name = Name::optional,
           .name = "NUMBER",
           .names_file = false,
           .summary = "Novint's Falcon over USB, without the maker's SDK",
           .spec = "falcon",
           .open = open_falcon,
           .library = falcon_library,
           .takes_firmware = true,
           .buttons = 4,
           .deadman_button = 1,
           .clutch_button = 2},
    Driver{.kind = "hapi",
           .takes_name = Name::required,
           .name = "PORT",
           .names_file = false,
           .summary = "Haply's open 2-dof board at a serial port, /dev/ttyACM0",
           .spec = "hapi_2dof",
           .open = open_hapi,
           .library = nullptr},
    Driver{.kind = "gamepad",
           .takes_name = Name::optional,
           .name = "EVENT",
           .names_file = false,
           .summary = "a gamepad, which moves the tool and gives no force",
           .spec = "simulated_6dof",
           .open = open_gamepad,
           .library = nullptr,
           .gives_force = false,
           .buttons = kPadButtons.size()},
    Driver{.kind = "spacemouse",
           .takes_name = Name::optional,
           .name = "EVENT",
           .names_file = false,
           .summary = "a 3D mouse, which moves and turns the tool and gives no force",
           .spec = "simulated_6dof",
           .open = open_spacemouse,
           .library = nullptr,
           .gives_force = false,
           .buttons = kMouseButtons.size()},
    Driver{.kind = "plugin",
           .takes_name = Name::required,
           .name = "FILE.so[:ARGUMENTS]",
           .names_file = false,
           .summary = "a plugin of your own, feltwire_device_v1.h",
           .spec = "simulated",
           .open = open_plugin,
           .library = nullptr,
           .buttons = 32,
           .deadman_button = 1,
           .clutch_button = 2},
};

/// "KIND", "KIND:NAME" or "KIND[:NAME]".
std::string spelling(const Driver& driver) {
  std::string kind(driver.kind);
  const std::string named = ":" + std::string(driver.name);
  switch (driver.takes_name) {
    case Name::none:
      return kind;
    case Name::optional:
      return kind + "[" + named + "]";
    case Name::required:
      break;
  }
  return kind + named;
}

}  // namespace

std::span<const Driver> drivers() { return kDrivers; }

std::string driver_choices() {
  std::string text;
  for (const Driver& driver : kDrivers)
    text.append(text.empty() ? "" : "; ")
        .append(spelling(driver) + " (" + std::string(driver.summary) + ")");
  return text;
}

DriverChoice chosen_driver(std::string_view words) {
  const std::size_t colon = words.find(':');
  const std::string_view kind = words.substr(0, colon);
  const bool named = colon != std::string_view::npos && colon + 1 < words.size();
  const Driver* driver = find_choice(kDrivers, kind, &Driver::kind);
  if (driver == nullptr)
    throw std::invalid_argument("unknown device '" + std::string(words) +
                                "'; use one of: " + choices(kDrivers, " ", spelling));
  if (named ? driver->takes_name == Name::none
            : driver->takes_name == Name::required || colon != std::string_view::npos)
    throw std::invalid_argument("--device " + std::string(words) + ": write it as " +
                                spelling(*driver));
  return {driver, named ? std::string(words.substr(colon + 1)) : std::string()};
}

std::string firmware_for(const Driver& driver, const std::string& file) {
  if (!file.empty() && !driver.takes_firmware)
    throw std::invalid_argument("--firmware is for --device falcon; leave it out");
  return file;
}

}  // namespace feltwire
