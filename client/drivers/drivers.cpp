#include "client/drivers/drivers.hpp"

#include <array>
#include <stdexcept>
#include <utility>

#include "client/drivers/force_dimension/force_dimension.hpp"
#include "client/drivers/haply/hapi.hpp"
#include "client/drivers/haply/haply.hpp"
#include "client/drivers/joystick/joystick_device.hpp"
#include "client/drivers/novint/falcon.hpp"
#include "client/drivers/open_haptics/open_haptics.hpp"
#include "client/drivers/plugin/plugin_device.hpp"
#include "client/hands/plant_file.hpp"
#include "client/hands/replay_device.hpp"
#include "client/hands/simulated_device.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/file_error.hpp"
#include "core/device/spec_names.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace {

using Name = Driver::Name;

std::string whole_name(std::string_view name) { return std::string(name); }

/// Reads the plant from its file. The plant of a device that nobody holds has no hand.
Plant requested_plant(const DeviceRequest& request) {
  if (request.name.empty()) return {};
  Plant plant = load_plant(plant_file_of(request.name));
  if (!request.held) plant.hand = {};
  return plant;
}

OpenedDevice open_simulated(const DeviceRequest& request) {
  SourcedSpec described = requested_spec(request.spec, "simulated");
  std::vector<std::string> notes = assumptions(described);
  SimulatedHandOptions options{.spec = std::move(described.spec),
                               .hand = request.held ? Hand{} : kNoHand,
                               .task = request.task,
                               .wrist = request.wrist,
                               .own_center = request.own_center,
                               .own_normal = request.own_normal,
                               .leads_from = request.leads_from,
                               .presses_at = request.presses_at,
                               .plant = requested_plant(request)};
  try {
    auto device = std::make_unique<SimulatedDevice>(options);
    const SimulatedDevice& opened = *device;
    return {std::move(device), std::move(notes), [&opened] { return opened.true_energy(); }};
  } catch (const PlantError& error) {
    throw FileError(plant_file_of(request.name) + ": " + error.field + ": " + error.why);
  }
}

OpenedDevice open_replay(const DeviceRequest& request) {
  const SourcedSpec described = requested_spec(request.spec, "simulated");
  return {make_replay_device(request.name, described.spec, request.leads_from),
          assumptions(described)};
}

constexpr std::array kDrivers = {
    Driver{.kind = "simulated",
           .takes_name = Name::optional,
           .name = "plant=FILE.json",
           .file = plant_file_of,
           .summary = "a simulated hand; FILE.json sets motor lag and transmission",
           .spec = "simulated",
           .open = open_simulated,
           .library = nullptr,
           .held_by_person = false,
           .buttons = 1},
    Driver{.kind = "replay",
           .takes_name = Name::required,
           .name = "FILE.csv",
           .file = whole_name,
           .summary = "a recorded movement; columns t,x,y,z and optionally qw,qx,qy,qz",
           .spec = "simulated",
           .open = open_replay,
           .library = nullptr,
           .held_by_person = false,
           .gives_force = false},
#ifdef FELTWIRE_DRIVER_FORCE_DIMENSION
    Driver{.kind = "forcedimension",
           .takes_name = Name::optional,
           .name = "NUMBER",
           .file = nullptr,
           .summary = "omega, delta, sigma, lambda, Falcon, with the maker's SDK",
           .spec = "omega.7",
           .open = open_force_dimension,
           .library = force_dimension_library,
           .buttons = 8,
           .deadman_button = 2,
           .clutch_button = 1},
#endif
#ifdef FELTWIRE_DRIVER_OPEN_HAPTICS
    Driver{.kind = "openhaptics",
           .takes_name = Name::optional,
           .name = "NAME",
           .file = nullptr,
           .summary = "Touch, Touch X, Premium, with the maker's OpenHaptics",
           .spec = "touch",
           .open = open_haptics,
           .library = open_haptics_library,
           .buttons = 4,
           .deadman_button = 1,
           .clutch_button = 2},
#endif
#ifdef FELTWIRE_DRIVER_HAPLY
    Driver{.kind = "haply",
           .takes_name = Name::optional,
           .name = "ID@PORT",
           .file = nullptr,
           .summary = "Inverse3, Inverse3x, Minverse, with the maker's service",
           .spec = "inverse3",
           .open = open_haply,
           .library = haply_usual_service,
           .buttons = 3,
           .deadman_button = 1,
           .clutch_button = 2},
#endif
#ifdef FELTWIRE_DRIVER_NOVINT
    Driver{.kind = "falcon",
           .takes_name = Name::optional,
           .name = "NUMBER",
           .file = nullptr,
           .summary = "Novint's Falcon over USB, without the maker's SDK",
           .spec = "falcon",
           .open = open_falcon,
           .library = falcon_library,
           .takes_firmware = true,
           .buttons = 4,
           .deadman_button = 1,
           .clutch_button = 2},
#endif
#ifdef FELTWIRE_DRIVER_HAPLY
    Driver{.kind = "hapi",
           .takes_name = Name::required,
           .name = "PORT",
           .file = nullptr,
           .summary = "Haply's open 2-dof board at a serial port, /dev/ttyACM0",
           .spec = "hapi_2dof",
           .open = open_hapi,
           .library = nullptr},
#endif
#ifdef FELTWIRE_DRIVER_JOYSTICK
    Driver{.kind = "gamepad",
           .takes_name = Name::optional,
           .name = "EVENT",
           .file = nullptr,
           .summary = "a gamepad; it moves the tool and gives no force",
           .spec = "simulated_6dof",
           .open = open_gamepad,
           .library = nullptr,
           .gives_force = false,
           .buttons = kPadButtons.size()},
    Driver{.kind = "spacemouse",
           .takes_name = Name::optional,
           .name = "EVENT",
           .file = nullptr,
           .summary = "a 3D mouse; it moves and rotates the tool and gives no force",
           .spec = "simulated_6dof",
           .open = open_spacemouse,
           .library = nullptr,
           .gives_force = false,
           .buttons = kMouseButtons.size()},
#endif
    Driver{.kind = "plugin",
           .takes_name = Name::required,
           .name = "FILE.so[:ARGUMENTS]",
           .file = nullptr,
           .summary = "your own plugin, see feltwire_device_v1.h",
           .spec = "simulated",
           .open = open_plugin,
           .library = nullptr,
           .buttons = 32,
           .deadman_button = 1,
           .clutch_button = 2},
};

/// The option of the build (cmake/drivers.cmake) that a kind of device needs.
struct BuildOption {
  std::string_view kind, option;
};
constexpr std::array kBuildOptions = {
    BuildOption{"forcedimension", "FELTWIRE_DRIVER_FORCE_DIMENSION"},
    BuildOption{"openhaptics", "FELTWIRE_DRIVER_OPEN_HAPTICS"},
    BuildOption{"haply", "FELTWIRE_DRIVER_HAPLY"},
    BuildOption{"falcon", "FELTWIRE_DRIVER_NOVINT"},
    BuildOption{"hapi", "FELTWIRE_DRIVER_HAPLY"},
    BuildOption{"gamepad", "FELTWIRE_DRIVER_JOYSTICK"},
    BuildOption{"spacemouse", "FELTWIRE_DRIVER_JOYSTICK"},
};

/// Returns "KIND", "KIND:NAME" or "KIND[:NAME]".
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

/// Returns only small letters and digits, so "Omega 7" matches "omega.7".
std::string bare(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) out += c;
  }
  return out;
}

/// Returns the specification that matches a device name, if a user gives this name in place of a
/// driver. Empty: no match.
std::string meant_spec(std::string_view words) {
  constexpr std::size_t kFewest = 4;  // least number of letters that name a family
  const std::string given = bare(words);
  if (given.empty()) return {};
  const std::vector<std::string> specs = device_spec_names();
  for (const std::string& spec : specs)
    if (bare(spec) == given) return spec;
  if (given.size() < kFewest) return {};
  for (const std::string& spec : specs)
    if (bare(spec).starts_with(given)) return spec;
  return {};
}

/// The driver of all devices whose name begins with `device`.
struct Family {
  std::string_view device, kind;
};
constexpr std::array kFamilies = {
    Family{"omega", "forcedimension"},
    Family{"delta", "forcedimension"},
    Family{"sigma", "forcedimension"},
    Family{"lambda", "forcedimension"},
    Family{"touch", "openhaptics"},
    Family{"phantom", "openhaptics"},
    Family{"geomagic", "openhaptics"},
    Family{"inverse", "haply"},
    Family{"falcon", "falcon"},
    Family{"novint", "falcon"},
    Family{"hapi", "hapi"},
};

/// The remedy where this program was built without the driver of that kind; empty: it has none.
std::string remedy_without(std::string_view kind) {
  const BuildOption* build = find_named(kBuildOptions, kind, &BuildOption::kind);
  if (build == nullptr) return {};
  return "this program was built without that driver; build it with -D" +
         std::string(build->option) + "=ON";
}

/// Returns the option that selects the device of this name. Empty: it is of no known family.
std::string option_for(std::string_view name) {
  for (const Family& family : kFamilies) {
    if (!name.starts_with(family.device)) continue;
    if (const Driver* driver = find_named(kDrivers, family.kind, &Driver::kind))
      return "--device " + spelling(*driver);
    return "--device " + std::string(family.kind) + " (" + remedy_without(family.kind) + ")";
  }
  return {};
}

[[noreturn]] void refuse_device(std::string_view words) {
  if (const std::string remedy = remedy_without(words.substr(0, words.find(':'))); !remedy.empty())
    throw std::invalid_argument("--device " + std::string(words) + ": " + remedy);
  const std::string unknown = "unknown device '" + std::string(words) + "'";
  const std::string spec = meant_spec(words);
  const std::string option = option_for(spec.empty() ? bare(words) : spec);
  if (spec.empty())
    throw std::invalid_argument(unknown + "; " +
                                (option.empty()
                                     ? "use one of: " + joined_names(kDrivers, " ", spelling)
                                     : "for a device of this family or maker give " + option));
  throw std::invalid_argument(
      unknown + ": " + spec + " is a specification; for the device itself give " +
      (option.empty() ? "--device plugin:FILE.so (docs/devices.md)" : option) +
      ", for a simulated one --device simulated --spec " + spec);
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
  const Driver* driver = find_named(kDrivers, kind, &Driver::kind);
  if (driver == nullptr) refuse_device(words);
  if (named ? driver->takes_name == Name::none
            : driver->takes_name == Name::required || colon != std::string_view::npos)
    throw std::invalid_argument("--device " + std::string(words) + ": write it as " +
                                spelling(*driver));
  DriverChoice choice{driver, named ? std::string(words.substr(colon + 1)) : std::string()};
  if (named && driver->file != nullptr) driver->file(choice.name);  // throws for an invalid name
  return choice;
}

std::string firmware_for(const Driver& driver, const std::string& file) {
  if (!file.empty() && !driver.takes_firmware)
    throw std::invalid_argument("firmware of --device is for falcon; leave it out");
  return file;
}

}  // namespace feltwire
