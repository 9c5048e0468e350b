#include "client/app/device_settings.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "client/drivers/drivers.hpp"
#include "core/base/enum_names.hpp"
#include "protocol/command_line/settings.hpp"

namespace feltwire {
namespace {

constexpr auto kHandGroup = "Simulated hand (--device simulated:path=slide,depth=0.01)";
constexpr auto kSteeringGroup = "Gamepad and 3D mouse (--device gamepad:steer_speed=0.05)";

void add_hand(CLI::App& keys, OptionValues& values, HandTask& task) {
  const auto group = kHandGroup;
  keys.add_option("--path", values.device.hand.path,
                  "Movement of the hand: " + joined_names(kHandPathNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option(
          "--wrist", values.device.hand.wrist,
          "Rotation of the hand, if --spec senses rotation: " + joined_names(kWristPathNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option("--wrist_angle", values.device.hand.wrist_angle,
                  "[rad] Amplitude of the rotation")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--center", values.device.hand.center,
                  "X,Y,Z [m] Point on the surface. For orbit: centre of the circle. Default: from "
                  "the scene, else 0,0,0")
      ->delimiter(',')
      ->group(group);
  keys.add_option(
          "--normal", values.device.hand.normal,
          "X,Y,Z Outward normal of the surface at this point. Default: from the scene, else 0,0,1")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--radius", task.radius, "[m] Amplitude of the movement along the surface")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--frequency", task.frequency, "[Hz] Frequency of the movement")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--depth", task.depth, "[m] Intended depth of the hand below the surface")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--lead_in", task.lead_in, "[s] Time until the hand reaches its depth")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--tremor", task.tremor,
                  "[m] RMS amplitude of the hand's tremor on each axis. The tremor has 8 to 12 Hz")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--seed", task.seed, "Seed of the tremor's random numbers")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--press_button", values.device.hand.press,
                  "[s] Time at which the hand presses button 1 for 0.1 s. The hand releases the "
                  "enabling switch from 0.5 s before until 0.5 s after")
      ->group(group);
  keys.add_option("--plant", values.device.hand.plant,
                  "FILE.json that sets motor lag and transmission")
      ->group(group);
}

void add_numbers(CLI::App& keys, OptionValues& values) {
  const auto group = "Numbers and firmware of a device (--device haply:damping=0.5,mass=0.1)";
  keys.add_option("--damping", values.device.damping,
                  "B or BX,BY,BZ [N s/m] Damping of the device. Default: from the specification")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--mass", values.device.mass,
                  "[kg] Lower bound of the handle's mass in every direction. Default: from the "
                  "specification")
      ->group(group);
  keys.add_option("--firmware", values.device.firmware,
                  "FILE with the maker's firmware. A Falcon loses its firmware when its power is "
                  "off")
      ->group(group);
}

void add_mapping(CLI::App& keys, OptionValues& values) {
  const auto group = "Workspace of a device in the scene (--device haply:map_scale=3)";
  keys.add_option("--map_scale", values.device.map.scale,
                  "Displacement of the tool divided by displacement of the hand, 0.01 to 100. The "
                  "scene's force is multiplied by the same factor")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--map_rotate", values.device.map.rotate,
                  "X,Y,Z [deg] Rotate the device's axes by this rotation vector. 0,0,90 maps the "
                  "device's x axis to the scene's y axis")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--map_translate", values.device.map.translate,
                  "X,Y,Z [m] Position in the scene of the centre of the device's workspace")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--map_mirror", values.device.map.mirror,
                  "Axis of the device to reverse: x, y or z")
      ->group(group);
}

void add_buttons(CLI::App& keys, OptionValues& values, ClientOptions& options) {
  const auto group =
      "Buttons of a device, its tool, and the start of its force (--device "
      "falcon:deadman_button=3)";
  keys.add_option("--deadman_button", values.device.buttons.deadman,
                  "Button that is the enabling switch, counted from 1. 0: none. Default: the "
                  "driver's choice")
      ->group(group);
  keys.add_option("--clutch_button", values.device.buttons.clutch,
                  "Button that is the clutch, counted from 1. The tool does not move while the "
                  "button is held. 0: none. Default: the driver's choice")
      ->group(group);
  keys.add_option("--emergency_button", values.device.buttons.emergency,
                  "Button that removes all force at once, counted from 1. The space bar in the "
                  "terminal does the same. The key r restores the force")
      ->group(group);
  keys.add_option("--robot_button", options.servo.seat_button,
                  "Button that selects the next robot, counted from 1. It works while the enabling "
                  "switch is released")
      ->group(group);
  keys.add_option("--tool_weight", values.device.tool_weight,
                  "Weight of a tool at the handle, 0.05kg or 0.5N. A constant force along the "
                  "device's z axis carries it")
      ->group(group);
  keys.add_option("--await_still", values.device.await_still,
                  "[s] The force starts after the hand was still for this time, or when the "
                  "enabling switch is pressed. 0: no wait. Default: 0.25 for a device that a "
                  "person holds, else 0")
      ->group(group);
}

void add_steering(CLI::App& keys, SteeringOptions& steering) {
  const auto group = kSteeringGroup;
  keys.add_option("--steer_speed", steering.speed, "[m/s] Speed of the tool at full deflection")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--steer_turn", steering.turn,
                  "[rad/s] Angular speed of the tool at full deflection")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--dead_zone", steering.dead_zone,
                  "Share of an axis's range that counts as rest, 0 to 0.5. A larger dead zone of "
                  "the kernel takes precedence")
      ->capture_default_str()
      ->group(group);
}

/// Throws std::invalid_argument if a setting of a simulated hand or of a gamepad is given for
/// another kind of device.
void require_kind(const CLI::App& keys, std::string_view kind) {
  const bool simulated = kind == "simulated";
  const bool steered = kind == "gamepad" || kind == "spacemouse";
  for (const CLI::Option* option : keys.get_options()) {
    if (option->count() == 0) continue;
    const std::string& group = option->get_group();
    if (group == kHandGroup ? simulated : group != kSteeringGroup || steered) continue;
    throw std::invalid_argument(
        "--device: " + option->get_lnames().front() + " is for " +
        (group == kHandGroup ? "a simulated hand" : "gamepad and spacemouse") + "; leave it out");
  }
}

/// Throws std::invalid_argument for a number that no hand can have.
void require_hand(const HandTask& task) {
  const auto require = [](bool good, const char* message) {
    if (!good) throw std::invalid_argument(message);
  };
  const auto is_size = [](double value) { return value >= 0.0 && std::isfinite(value); };
  require(is_size(task.radius), "radius of --device must be 0 or more [m]");
  require(is_size(task.frequency), "frequency of --device must be 0 or more [Hz]");
  require(is_size(task.tremor), "tremor of --device must be 0 or more [m]");
  require(is_size(task.lead_in) && task.lead_in > 0.0, "lead_in of --device must be above 0 [s]");
  require(std::isfinite(task.depth), "depth of --device must be a finite number [m]");
}

/// Returns how the name of such a device may look: a file's may have a '='.
SettingsBegin begin_of(std::string_view kind) {
  const Driver* driver = find_named(drivers(), kind, &Driver::kind);
  const bool file = driver == nullptr || kind == "replay" || kind == "plugin" || kind == "hapi";
  return file ? SettingsBegin::file : SettingsBegin::name;
}

/// Throws std::invalid_argument if a plugin would get a setting that it has in common with every
/// device, and the setting is not given as such.
void require_own_arguments(const DeviceText& given, const CLI::App& keys) {
  const std::string_view arguments = std::string_view(given.arguments).substr(1);
  for (const CLI::Option* option : keys.get_options()) {
    const std::string& name = option->get_lnames().front();
    const auto value = setting_in(arguments, name);
    const bool common = option->get_group() != kHandGroup && option->get_group() != kSteeringGroup;
    const auto is_it = [&](const std::string& one) { return one.starts_with(name + "="); };
    if (!value || !common || std::ranges::any_of(given.settings, is_it)) continue;
    const std::string setting = name + "=" + std::string(*value);
    throw std::invalid_argument("--device plugin: " + setting +
                                " stands behind the second colon, so the plugin gets it and the "
                                "client does not; write it before: plugin:" +
                                given.name + "," + setting +
                                ":... For an argument of the plugin with this name, write both");
  }
}

/// The text of --device again, with these settings.
std::string joined(const DeviceText& given) {
  std::string text = given.name;
  for (const std::string& setting : given.settings) text += (text.empty() ? "" : ",") + setting;
  text += given.arguments;
  return text.empty() ? given.kind : given.kind + ":" + text;
}

}  // namespace

std::string DeviceText::device() const {
  const std::string whole = name + arguments;
  return whole.empty() ? kind : kind + ":" + whole;
}

void add_device_settings(CLI::App& keys, OptionValues& values, HandTask& task,
                         ClientOptions& options) {
  keys.set_help_flag();
  add_hand(keys, values, task);
  add_numbers(keys, values);
  add_mapping(keys, values);
  add_buttons(keys, values, options);
  add_steering(keys, options.device.steering);
}

DeviceText split_device(std::string_view text, const CLI::App& keys) {
  const std::size_t colon = text.find(':');
  const std::string kind(text.substr(0, colon));
  if (const std::size_t comma = kind.find(',');
      comma != std::string::npos &&
      find_named(drivers(), kind.substr(0, comma), &Driver::kind) != nullptr)
    throw std::invalid_argument("--device " + std::string(text) +
                                ": write a colon behind the kind: " + kind.substr(0, comma) + ":" +
                                std::string(text.substr(comma + 1)));
  // chosen_driver() has the error of a colon with nothing behind it.
  if (colon == std::string_view::npos || colon + 1 == text.size())
    return {std::string(text), {}, {}, {}};
  DeviceText given{kind, {}, {}, {}};
  std::string_view name = text.substr(colon + 1);
  if (kind == "plugin") {
    const std::size_t end = std::min(name.find(':'), name.size());
    given.arguments = name.substr(end);
    name = name.substr(0, end);
  }
  SettingsText split = split_settings(name, keys, begin_of(kind), "--device " + kind);
  given.name = std::move(split.begin);
  given.settings = std::move(split.settings);
  if (!given.arguments.empty()) require_own_arguments(given, keys);
  return given;
}

void read_device_settings(CLI::App& keys, OptionValues& values, const HandTask& task) {
  const DeviceText given = split_device(values.device.kind, keys);
  read_settings(keys, given.settings, "--device");
  require_hand(task);
  values.device.kind = given.device();
  require_kind(keys, given.kind);
  if (!values.device.hand.plant.empty()) values.device.kind += ":plant=" + values.device.hand.plant;
}

std::string device_in_folder(const std::string& value, const std::filesystem::path& folder,
                             const CLI::App& keys) {
  DeviceText given = split_device(value, keys);
  const DriverChoice chosen = chosen_driver(given.device());
  if (chosen.driver->file != nullptr && !given.name.empty())
    given.name = (folder / given.name).string();
  for (std::string& setting : given.settings)
    for (const std::string_view file : {"plant=", "firmware="})
      if (setting.starts_with(file) && setting.size() > file.size())
        setting = std::string(file) + (folder / setting.substr(file.size())).string();
  return joined(given);
}

BareDevice bare_device(const std::string& device) {
  OptionValues values;
  HandTask task;
  ClientOptions options;
  CLI::App keys{""};
  add_device_settings(keys, values, task, options);
  for (const std::string& setting : split_device(device, keys).settings)
    if (!setting.starts_with("plant=") && !setting.starts_with("firmware="))
      throw std::invalid_argument("--device: " + setting.substr(0, setting.find('=')) +
                                  " has no effect in this command; leave it out");
  values.device.kind = device;
  read_device_settings(keys, values, task);
  DriverChoice chosen = chosen_driver(values.device.kind);
  BareDevice bare;
  bare.driver = chosen.driver;
  bare.request.name = std::move(chosen.name);
  bare.request.firmware = firmware_for(*chosen.driver, values.device.firmware);
  return bare;
}

Renamed renamed_device_options(const CLI::App& keys) {
  Renamed renamed;
  for (const CLI::Option* option : keys.get_options()) {
    const std::string& name = option->get_lnames().front();
    std::string old = name, kind = "KIND";
    std::replace(old.begin(), old.end(), '_', '-');
    if (option->get_group() == kHandGroup) kind = "simulated";
    if (option->get_group() == kSteeringGroup) kind = "gamepad";
    if (name == "firmware") kind = "falcon";
    renamed.push_back({old, "--device " + kind + ":" + name + "=..."});
  }
  return renamed;
}

}  // namespace feltwire
