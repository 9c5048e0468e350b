#include "client/app/option_values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "client/app/session_settings.hpp"
#include "client/run/hold_time.hpp"
#include "client/run/output_files.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/utf8.hpp"
#include "core/device/device_file.hpp"
#include "core/recording/flight_files.hpp"
#include "protocol/net/busy_poll.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {
namespace {

constexpr double kLongestDuration = 1e7;  // [s] longest accepted duration, about four months

Vec3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

void require(bool good, const char* message) {
  if (!good) throw std::invalid_argument(message);
}

/// Sets the safety limits. By default, they protect the hand as far as the method allows.
void choose_safety(const OptionValues& values, ClientOptions& options) {
  SafetyLimits& given = options.servo.safety;
  const SafetyLimits usual = protect_hand(options.parameters).safety;
  given.force.small = values.limits.wait_for_small_force.value_or(usual.force.small);
  given.torque.small = std::isfinite(given.force.small) ? usual.torque.small : given.force.small;
  given.force.speed = values.limits.velocity_limit.value_or(usual.force.speed);
  given.ramp_up = values.limits.ramp_up.value_or(usual.ramp_up);
}

/// Returns the changes that an admin may make to this session. With a person's hand, only changes
/// that are safe for the hand are possible. Throws std::invalid_argument.
ChangesTaken changes(const OptionValues& values, const ClientOptions& options) {
  const auto laws = enum_from_name<LawsTaken>("--changes", values.changes, kLawsTakenNames);
  require(laws != LawsTaken::any || !options.driver->held_by_person,
          "--changes any is for --device simulated and replay, which no person holds; give "
          "--changes safe");
  return {.laws = laws, .link = laws != LawsTaken::none && options.link.has_value()};
}

/// Returns the role that `word` names: operator, pointer or observer. Throws std::invalid_argument.
Role role_of_hand(const std::string& word) {
  for (const Role one : {Role::operator_, Role::pointer, Role::observer})
    if (name(one) == word) return one;
  throw std::invalid_argument("--role must be operator, pointer or observer, is '" + word + "'");
}

/// Sets `let_go_after`, the longest time of a force without a servo tick, and the longest hold time
/// that the server may grant. Throws std::invalid_argument.
void choose_holds(const OptionValues& values, ClientOptions& options) {
  constexpr double kLongest = 1.0;  // [s] longest hold time
  if (values.limits.let_go_after) {
    require(*values.limits.let_go_after > 0.0 && *values.limits.let_go_after <= kLongest,
            "--let-go-after must be above 0 and at most 1 s; leave it out for the usual time");
    require(*values.limits.let_go_after >= 2.0 * options.parameters.servo_period,
            "--let-go-after must last two periods of the servo or more, or each late tick ends the "
            "run; leave it out for the usual time");
    options.hold.let_go_after = *values.limits.let_go_after;
  }
  if (values.limits.longest_hold_time) {
    require(*values.limits.longest_hold_time >= options.parameters.hold_time &&
                *values.limits.longest_hold_time <= kLongest,
            "--longest-hold-time must be from --hold-time to 1 s; leave it out, and the server may "
            "not lengthen the hold time");
    options.hold.longest = *values.limits.longest_hold_time;
  }
}

/// Returns the files that have a path.
std::vector<NamedFile> named(std::vector<NamedFile> files) {
  std::erase_if(files, [](const NamedFile& file) { return file.path.empty(); });
  return files;
}

std::vector<NamedFile> written_files(const OptionValues& values) {
  std::string record = values.files.record;
  if (values.files.record_limits.any())
    record = numbered({record, values.files.record_limits}, 1).string();
  return named(
      {{"--report", values.files.report}, {"--record", record}, {"--view", values.files.view}});
}

std::vector<NamedFile> read_files(const OptionValues& values) {
  const CredentialOptions& c = values.credentials;
  const DriverChoice device = chosen_driver(values.device.kind);
  const bool reads = device.driver->file != nullptr && !device.name.empty();
  return named({{"--device", reads ? device.driver->file(device.name) : std::string()},
                {"--config", values.config},
                {"firmware of --device", values.device.firmware},
                {"--fingerprint-file", c.fingerprint_file},
                {"--ca", c.ca},
                {"--certificate", c.certificate},
                {"--key", c.key},
                {"--token-file", c.token_file}});
}

/// Sets the flight recorder's folder. Recording is the default, so a failed session leaves data.
void choose_flight_recorder(const std::string& folder, RunOptions& options) {
  if (folder == "off") return;
  options.files.flight_recorder_required = !folder.empty();
  options.files.flight_recorder =
      folder.empty() ? state_flight_folder() : std::optional<std::filesystem::path>(folder);
}

/// Sets and checks the size limits of the recording. Throws std::invalid_argument.
void choose_recording(const OptionValues& values, ClientOptions& options) {
  const RecordingLimits& limits = values.files.record_limits;
  options.files.record_limits = limits;
  require(limits.mebibytes >= 1.0, "--record-max-mib must be 1 MiB or more");
  require(limits.seconds >= 1.0, "--record-max-seconds must be 1 s or more");
  require(!limits.any() || is_mcap(values.files.record),
          "--record-max-mib and --record-max-seconds apply only to MCAP recordings; give --record "
          "FILE.mcap");
}

Damping damping(const std::vector<double>& numbers) {
  require(numbers.size() == 1 || numbers.size() == 3,
          "damping of --device must be one number [N s/m], or three along x, y and z: BX,BY,BZ");
  return numbers.size() == 1 ? Damping(numbers[0])
                             : Damping(Vec3(numbers[0], numbers[1], numbers[2]));
}

/// Sets the driver and its request. `task`: path of a simulated hand. Throws std::invalid_argument.
void choose_device(const OptionValues& values, HandTask task, ClientOptions& options) {
  DriverChoice chosen = chosen_driver(values.device.kind);
  task.path = options.check ? HandPath::press : hand_path(values.device.hand.path);
  if (values.device.hand.center) task.center = vector(*values.device.hand.center);
  require(task.center.allFinite(), "center of --device must be three finite numbers [m]");
  if (values.device.hand.normal) set_normal(task, vector(*values.device.hand.normal));
  require(std::abs(values.device.hand.wrist_angle) < std::numbers::pi,
          "wrist_angle of --device must be less than pi [rad]");
  const WristTask wrist = {options.check ? WristPath::still : wrist_path(values.device.hand.wrist),
                           values.device.hand.wrist_angle};
  options.device_kind = values.device.kind;
  options.driver = chosen.driver;
  options.device = {.name = std::move(chosen.name),
                    .spec = {values.device.spec, {}, values.device.mass},
                    .task = task,
                    .wrist = wrist,
                    .own_center = values.device.hand.center.has_value(),
                    .own_normal = values.device.hand.normal.has_value(),
                    .leads_from = values.lead,
                    .presses_at = values.device.hand.press,
                    .firmware = {},
                    .steering = options.device.steering};
  options.device.firmware = firmware_for(*chosen.driver, values.device.firmware);
  require(!values.device.hand.press ||
              (chosen.driver->kind == "simulated" && *values.device.hand.press >= 0.0 &&
               std::isfinite(*values.device.hand.press)),
          "press_button of --device simulated is a time of 0 or more [s]");
  validate(options.device.steering);
  if (values.device.damping) options.device.spec.damping = damping(*values.device.damping);
  // Check the specification before the device opens, so that its errors are reported first.
  requested_spec(options.device.spec, chosen.driver->spec);
}

/// Parses "0.05kg" or "0.5N" into a weight [N]. Throws std::invalid_argument.
double weight(const std::string& values) {
  constexpr double kGravity = 9.80665;  // [m/s^2]
  const bool mass = values.ends_with("kg"), force = values.ends_with("N");
  const std::size_t unit = mass ? 2 : 1;
  double number = 0.0;
  const char* const end = values.data() + values.size() - (values.empty() ? 0 : unit);
  const auto parsed = std::from_chars(values.data(), end, number);
  require((mass || force) && parsed.ec == std::errc() && parsed.ptr == end && number > 0.0 &&
              std::isfinite(number),
          "tool_weight of --device must be a number above 0 and its unit: 0.05kg, or 0.5N");
  return mass ? kGravity * number : number;
}

/// Throws std::invalid_argument unless the device has this button. Button 0 means no button.
void require_button(const char* option, int button, const Driver& driver, const char* remedy) {
  if (button >= 0 && button <= driver.buttons) return;
  throw std::invalid_argument(
      std::string(option) + ": of --device " + std::string(driver.kind) +
      (driver.buttons > 0 ? " the buttons 1 to " + std::to_string(driver.buttons) + " are read"
                          : std::string(" no button is read; ") + remedy));
}

/// Sets the buttons of the enabling switch and the clutch. Throws std::invalid_argument if the
/// device lacks a button, or if a button has two functions.
void choose_buttons(const OptionValues& values, int robot_button, const Driver& driver,
                    ProtectionOptions& options) {
  options.deadman_button = values.device.buttons.deadman;
  options.clutch_button = values.device.buttons.clutch;
  for (const auto& [option, chosen] : {std::pair("deadman_button", values.device.buttons.deadman),
                                       std::pair("clutch_button", values.device.buttons.clutch)}) {
    if (!chosen) continue;
    require_button(option, *chosen, driver, "leave it out");
    for (const auto& [other, button] :
         {std::pair("emergency_button", values.device.buttons.emergency),
          std::pair("robot_button", robot_button)})
      if (button != 0 && button == *chosen)
        throw std::invalid_argument(std::string(option) + " and " + other +
                                    " of --device are the same button; give each its own");
  }
  const int deadman = values.device.buttons.deadman.value_or(driver.deadman_button);
  const bool both =
      deadman != 0 && deadman == values.device.buttons.clutch.value_or(driver.clutch_button);
  if (both && (values.device.buttons.deadman || values.device.buttons.clutch))
    throw std::invalid_argument("button " + std::to_string(deadman) + " of --device " +
                                std::string(driver.kind) +
                                " would be the enabling switch and the clutch; give "
                                "deadman_button and clutch_button, each its own, or 0 for none");
}

/// Returns the tool weight, emergency button and still time. Throws std::invalid_argument.
ProtectionOptions protection(const OptionValues& values, const Driver& driver) {
  constexpr double kUsualStill = 0.25;  // [s] default of await_still for a hand that feels force
  ProtectionOptions options;
  if (!values.device.tool_weight.empty()) options.tool_weight = weight(values.device.tool_weight);
  options.emergency_button = values.device.buttons.emergency;
  options.still = values.device.await_still.value_or(
      driver.held_by_person && driver.gives_force ? kUsualStill : 0.0);
  require(options.tool_weight == 0.0 || driver.gives_force,
          "tool_weight of --device needs a device that gives force; leave it out");
  require_button("emergency_button", options.emergency_button, driver, "use the space bar");
  return options;
}

/// Returns the pose and scale of the device's workspace in the scene. Throws std::invalid_argument.
WorkspaceMapping mapping(const OptionValues& values) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  constexpr std::string_view kAxes = "xyz";
  WorkspaceMapping mapping;
  mapping.scale = values.device.map.scale;
  if (values.device.map.rotate) mapping.rotation = kDegree * vector(*values.device.map.rotate);
  if (values.device.map.translate) mapping.translation = vector(*values.device.map.translate);
  if (!values.device.map.mirror.empty())
    mapping.mirrored_axis = values.device.map.mirror.size() == 1
                                ? static_cast<int>(kAxes.find(values.device.map.mirror))
                                : -1;
  validate(mapping);
  return mapping;
}

/// Throws std::invalid_argument if the name is too long for the protocol. The server's error would
/// not say which name is too long.
void check_name(const char* option, const std::string& name) {
  if (!is_utf8(name))
    throw std::invalid_argument(std::string(option) + ": the name is not text in UTF-8");
  if (name.size() <= control::kMaxName) return;
  throw std::invalid_argument(std::string(option) + ": the name has " +
                              std::to_string(name.size()) + " bytes; at most " +
                              std::to_string(control::kMaxName) + " can be sent");
}

/// Returns the energy and power that the client accepts from a robot (--trust-robot).
RemoteTrust trust(const OptionValues& values) {
  // [J], [W] largest values of --trust-robot that are safe for the hand.
  constexpr double kMostPerContact = 1.0, kMostPower = 50.0;
  if (!values.trust) return {.per_contact = 0.0, .power = 0.0};
  const auto [per_contact, power] = *values.trust;
  require(
      per_contact >= 0.0 && per_contact <= kMostPerContact && power >= 0.0 && power <= kMostPower,
      "--trust-robot must be 0 to 1 J and 0 to 50 W, for example 0.1,5");
  return {.per_contact = per_contact, .power = power};
}

void choose_lead(const OptionValues& values, ClientOptions& options) {
  require(values.lead || !values.trust, "--trust-robot is for a hand with --lead; add --lead");
  require(values.lead || options.robot.empty(), "--robot is for a hand with --lead; add --lead");
  require(values.lead || options.servo.seat_button == 0,
          "robot_button of --device is for a hand with --lead; add --lead");
  if (!values.lead) return;
  check_name("--robot", options.robot);
  // [s] The server must first see the switch released for this time.
  constexpr double kShownReleased = 0.2;
  require(*values.lead >= kShownReleased && *values.lead <= kLongestDuration,
          "--lead must be from 0.2 to 1e7 s: the switch must be seen released first");
  require(options.role != Role::observer, "--lead is not for observers; leave out --role");
  require(options.parameters.local_model,
          "--lead needs the local model; leave out --local-model off");
  options.servo.leads = trust(values);
}

}  // namespace

void to_client_options(const OptionValues& values, HandTask task, ClientOptions& options) {
  if (values.has_server) {
    options.server = {parse_endpoint(values.connect), credentials(values.credentials)};
    if (options.list) return;
    require(!values.scene.empty() || options.check,
            "--scene is required; --list shows the existing scenes");
  } else {
    require(values.connect.empty() && values.scene.empty(),
            "--connect and --scene: there is no server; leave them out");
  }
  options.scene = values.scene;
  check_name("--scene", options.scene);
  check_name("--tool", options.tool);
  check_name("--name", options.name);
  require(options.duration >= 0.0 && options.duration <= kLongestDuration,
          "--duration must be from 0 to 1e7 s; 0 runs until it is stopped");
  require(options.patience >= 0.0 && options.patience <= kLongestDuration,
          "--reconnect must be from 0 to 1e7 s; 0 ends when the session is lost");

  require(possible_busy_poll(options.busy_poll),
          "--busy-poll must be from 0 to 1e6 us, or inf: never sleep");

  options.role = role_of_hand(values.role);
  require(values.files.view.empty() || options.role == Role::observer,
          "--view is only for observers; also give --role observer");
  choose_bound(values, options);
  options.parameters.servo_period = servo_period_of(values);
  options.hold.follows_period = !values.limits.hold_time;
  if (values.limits.hold_time) options.parameters.hold_time = *values.limits.hold_time;
  choose_hold_time(options.parameters, options.hold.follows_period);
  choose_traffic(values, options.role, options.parameters);
  validate(options.parameters);
  choose_holds(values, options);
  choose_safety(values, options);
  choose_lead(values, options);
  validate(options.servo, options.parameters);

  if (options.check) {
    constexpr double kUsual = 10.0;  // [s] default duration of a check
    require(values.device.kind == "simulated",
            "--check uses the simulated hand; leave out --device");
    if (options.duration == 0.0) options.duration = kUsual;
    task.depth = -task.clearance;  // keeps the hand above the surface
  }
  choose_device(values, task, options);
  options.mapping = mapping(values);
  options.protection = protection(values, *options.driver);
  require_button("robot_button", options.servo.seat_button, *options.driver, "leave it out");
  choose_buttons(values, options.servo.seat_button, *options.driver, options.protection);
  if (!values.files.report.empty()) options.files.report = values.files.report;
  if (!values.files.record.empty()) options.files.record = values.files.record;
  choose_recording(values, options);
  choose_flight_recorder(values.files.flight_recorder, options);
  if (!values.files.view.empty()) options.files.view = values.files.view;
  require_different(written_files(values), read_files(values));
  options.dscp = dscp(values.dscp);
  options.rehearses = values.rehearses;
  if (!values.link.empty()) options.link = parse_link(values.link);
  options.takes = changes(values, options);
  // Without a person, a short stall of the servo thread is harmless and must not end the session.
  if (!values.limits.let_go_after && !options.driver->held_by_person)
    options.hold.let_go_after = options.parameters.hold_time;
}

}  // namespace feltwire
