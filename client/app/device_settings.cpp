#include "client/app/device_settings.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "protocol/command_line/settings.hpp"

namespace feltwire {
namespace {

constexpr auto kHandGroup = "Simulated hand (--device simulated:path=slide,depth=0.01)";
constexpr auto kSteeringGroup = "Gamepad and 3D mouse (--device gamepad:steer_speed=0.05)";

void add_hand(CLI::App& keys, OptionValues& values, HandTask& task) {
  const auto group = kHandGroup;
  keys.add_option("--path", values.path, "Movement of the hand: " + joined_names(kHandPathNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option(
          "--wrist", values.wrist,
          "Rotation of the hand, if --spec senses rotation: " + joined_names(kWristPathNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option("--wrist_angle", values.wrist_angle, "[rad] Amplitude of the rotation")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--center", values.center,
                  "X,Y,Z [m] Point on the surface. For orbit: centre of the circle. Default: from "
                  "the scene, else 0,0,0")
      ->delimiter(',')
      ->group(group);
  keys.add_option(
          "--normal", values.normal,
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
  keys.add_option("--press_button", values.press,
                  "[s] Time at which the hand presses button 1 for 0.1 s. The hand releases the "
                  "enabling switch from 0.5 s before until 0.5 s after")
      ->group(group);
  keys.add_option("--plant", values.plant, "FILE.json that sets motor lag and transmission")
      ->group(group);
}

void add_mapping(CLI::App& keys, OptionValues& values) {
  const auto group = "Workspace of a device in the scene (--device haply:map_scale=3)";
  keys.add_option("--map_scale", values.map_scale,
                  "Displacement of the tool divided by displacement of the hand, 0.01 to 100. The "
                  "scene's force is multiplied by the same factor")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--map_rotate", values.map_rotate,
                  "X,Y,Z [deg] Rotate the device's axes by this rotation vector. 0,0,90 maps the "
                  "device's x axis to the scene's y axis")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--map_translate", values.map_translate,
                  "X,Y,Z [m] Position in the scene of the centre of the device's workspace")
      ->delimiter(',')
      ->group(group);
  keys.add_option("--map_mirror", values.map_mirror, "Axis of the device to reverse: x, y or z")
      ->group(group);
}

void add_buttons(CLI::App& keys, OptionValues& values, ClientOptions& options) {
  const auto group = "Buttons of a device, and its tool (--device falcon:deadman_button=3)";
  keys.add_option("--deadman_button", values.deadman_button,
                  "Button that is the enabling switch, counted from 1. 0: none. Default: the "
                  "driver's choice")
      ->group(group);
  keys.add_option("--clutch_button", values.clutch_button,
                  "Button that is the clutch, counted from 1. The tool does not move while the "
                  "button is held. 0: none. Default: the driver's choice")
      ->group(group);
  keys.add_option("--emergency_button", values.emergency_button,
                  "Button that removes all force at once, counted from 1. The space bar in the "
                  "terminal does the same. The key r restores the force")
      ->group(group);
  keys.add_option("--robot_button", options.servo.seat_button,
                  "Button that selects the next robot, counted from 1. It works while the enabling "
                  "switch is released")
      ->group(group);
  keys.add_option("--tool_weight", values.tool_weight,
                  "Weight of a tool at the handle, 0.05kg or 0.5N. A constant force along the "
                  "device's z axis carries it")
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

/// The settings alone, for what needs only their names.
struct SettingNames {
  CLI::App keys{""};
  OptionValues values;
  HandTask task;
  ClientOptions options;

  SettingNames() { add_device_settings(keys, values, task, options); }
};

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

}  // namespace

void add_device_settings(CLI::App& keys, OptionValues& values, HandTask& task,
                         ClientOptions& options) {
  keys.set_help_flag();
  add_hand(keys, values, task);
  add_mapping(keys, values);
  add_buttons(keys, values, options);
  add_steering(keys, options.device.steering);
}

DeviceText split_device(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon + 1 == text.size()) return {std::string(text), {}};
  const std::string kind(text.substr(0, colon));
  std::string_view name = text.substr(colon + 1), arguments;
  if (kind == "plugin") {
    const std::size_t end = std::min(name.find(':'), name.size());
    arguments = name.substr(end);
    name = name.substr(0, end);
  }
  const SettingNames known;
  SettingsText split;
  try {
    split = split_settings(name, known.keys);
    // No name of a simulated device has a '=': this is a misspelled setting.
    if (kind == "simulated" && split.begin.find('=') != std::string::npos)
      split_settings("seed=1," + split.begin, known.keys);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("--device " + kind + ": " + error.what());
  }
  const std::string whole = split.begin + std::string(arguments);
  return {whole.empty() ? kind : kind + ":" + whole, std::move(split.settings)};
}

void read_device_settings(OptionValues& values, HandTask& task, ClientOptions& options) {
  const DeviceText given = split_device(values.device);
  CLI::App keys;
  add_device_settings(keys, values, task, options);
  read_settings(keys, given.settings, "--device");
  values.device = given.device;
  require_kind(keys, std::string_view(given.device).substr(0, given.device.find(':')));
  if (!values.plant.empty()) values.device += ":plant=" + values.plant;
}

std::string device_settings_help() {
  const SettingNames known;
  return settings_help(known.keys);
}

Renamed renamed_device_options() {
  const SettingNames known;
  Renamed renamed;
  for (const CLI::Option* option : known.keys.get_options()) {
    const std::string& name = option->get_lnames().front();
    std::string old = name, kind = "KIND";
    std::replace(old.begin(), old.end(), '_', '-');
    if (option->get_group() == kHandGroup) kind = "simulated";
    if (option->get_group() == kSteeringGroup) kind = "gamepad";
    renamed.push_back({old, "--device " + kind + ":" + name + "=..."});
  }
  return renamed;
}

}  // namespace feltwire
