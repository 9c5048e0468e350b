#include "client/app/client_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <sstream>
#include <string_view>

#include "client/app/option_values.hpp"
#include "client/app/rival_options.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"
#include "core/command_line/environment.hpp"
#include "core/command_line/short_help.hpp"
#include "core/command_line/suggestion.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/session/profiles.hpp"

namespace feltwire {
namespace {

constexpr int kUsageError = 2;

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

ShortHelp short_help() {
  return {{{"connect", "HOST:PORT of the server's control port; IPv6 as [::1]:PORT"},
           {"list", "List the server's scenes and end"},
           {"check", "Say whether this machine and the network are fit for a session"},
           {"scene", "Name of the scene to join"},
           {"tool", "Name of the scene's tool to hold. Usually its first"},
           {"role", "operator, pointer, or observer (sees the scene, feels nothing)"},
           {"device",
            "simulated, replay:FILE.csv, haply, forcedimension, openhaptics,\n"
            "falcon, hapi:PORT, gamepad, spacemouse, plugin:FILE.so"},
           {"spec", "A built-in specification of the device, or FILE.json"},
           {"list-specs", "Print the built-in specifications and end"},
           {"duration", "[s] Length of the run. 0: until it is stopped"},
           {"report", "FILE.json for the numbers of the run"},
           {"record", "FILE.csv or FILE.mcap for a recording of every tick"},
           {"fingerprint-file", "FILE with the fingerprint of the server to trust"},
           {"ca", "FILE (PEM) of authorities to trust, instead of a fingerprint"},
           {"token-file", "FILE with your token; or set FELTWIRE_TOKEN to the token"},
           {"link", "Emulate a bad network: wifi, delay=25,jitter=5,loss=10 (--help-all)"},
           {"mode", "Bounding method (docs/bounding.md)"},
           {"rate", "[Hz] Rate of the servo loop, if the device does not set it"},
           {"max-force", "[N] Largest force on the hand"},
           {"lead", "[s] Time from which it leads the robot (docs/teleoperation.md)"},
           {"path", "Movement of the simulated hand: press|slide|orbit|figure-eight|taps"},
           {"center", "X,Y,Z [m] Middle of its movement, on the surface"},
           {"depth", "[m] Its intended depth below the surface"}},
          R"(
Every other option, and what a link can be: feltwire-client --help-all, docs/devices.md.
Commands, each with its own --help:
  admin      list the sessions of a running server, and change it (docs/admin.md)
  devices    list the connected devices, and their problems (docs/devices.md)
  identify   measure a device's damping, friction and mass (docs/devices.md)
Example, beside a server on this machine:
  export FELTWIRE_FINGERPRINT_FILE=~/.local/state/feltwire/fingerprint
  export FELTWIRE_TOKEN_FILE=~/.local/state/feltwire/local.token
  feltwire-client --connect localhost:6720 --scene room --path taps --duration 5)"};
}

void list_specs() {
  for (const SourcedSpec& described : sourced_builtin_devices())
    std::cout << spec_table(described) << "\n";
  throw CLI::Success();
}

}  // namespace

std::variant<ClientOptions, int> parse_options(int argc, char** argv) {
  ClientOptions options;
  SessionParameters& parameters = options.parameters;
  HandTask task;
  OptionValues values;

  CLI::App app{
      "feltwire-client: a haptic device, simulated or replayed, in a scene of a feltwire server."};
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "feltwire-client: " + visible(error.what() + advice(error, *failed)) + "; see --help\n";
  });
  add_helps(app);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-client"); },
      "Print version, commit, compiler and kind of build");
  app.add_option("--connect", values.connect,
                 "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required();
  add_credential_options(app, values.credentials);
  app.add_flag("--list", options.list, "List the server's scenes and end");
  app.add_flag("--check", options.check,
               "Run for ten seconds with a simulated hand that touches nothing, and say whether "
               "this machine and the network are fit for a session (docs/troubleshooting.md)");
  app.add_option("--scene", values.scene, "Name of the scene to join");
  app.add_option("--tool", options.tool,
                 "Name of the scene's tool to hold. When not given: the scene's first tool");
  app.add_option(
         "--role", values.role,
         "operator, pointer (a small hand, with a token of that role) or observer (sees the "
         "scene, feels nothing and moves nothing). The token must allow the role")
      ->capture_default_str();
  app.add_option("--device", values.device, "KIND or KIND:NAME. " + driver_choices())
      ->capture_default_str();
  app.add_option("--firmware", values.firmware,
                 "FILE with the maker's firmware, which a Falcon forgets when its power is off");
  app.add_option(
      "--lead", values.lead,
      "[s] Lead the scene's robot and feel its contacts (docs/teleoperation.md). The "
      "simulated or recorded hand holds its enabling switch from this time on, 0.2 or later");
  app.add_option("--robot", options.robot,
                 "Name of the seat whose robot it leads, in a scene with several. When not given: "
                 "the scene's first");
  app.add_option("--robot-button", options.servo.seat_button,
                 "Number of a button of the device, from 1, that goes on to the next robot while "
                 "the enabling switch is released");
  app.add_option("--deadman-button", values.deadman_button,
                 "Number of the button of the device, from 1, that is the enabling switch. 0: "
                 "none. When not given: as the driver has it (docs/devices.md)");
  app.add_option("--clutch-button", values.clutch_button,
                 "Number of the button of the device, from 1, that is the clutch: the tool stands "
                 "while it is held. 0: none. When not given: as the driver has it");
  app.add_option("--trust-robot", values.trust,
                 "J,W of a robot that you run yourself: energy that it may give the hand in one "
                 "contact [J], and over time [W] (docs/teleoperation.md). When not given: none")
      ->delimiter(',');
  app.add_option("--duration", options.duration,
                 "[s] Length of the run. 0: until it is stopped or the recording is over")
      ->capture_default_str();
  app.add_option("--report", values.report,
                 "FILE.json for the numbers of the run (docs/devices.md)");
  app.add_option("--record", values.record,
                 "FILE.csv or FILE.mcap for a recording of every tick (docs/recording.md)");
  app.add_option("--record-max-mib", values.record_limits.mebibytes,
                 "[MiB] Largest size of one file of an MCAP recording. Then the next file begins: "
                 "FILE-0001.mcap, FILE-0002.mcap");
  app.add_option("--record-max-seconds", values.record_limits.seconds,
                 "[s] Longest time in one file of an MCAP recording. Then the next file begins");
  app.add_option("--flight-recorder", values.flight_recorder,
                 "Folder for a recording of the last ten seconds. It is written when the run ends "
                 "with an error, when its session is lost, its device has a fault or its account "
                 "was overdrawn, and at SIGUSR1. off: none. When not given: "
                 "$XDG_STATE_HOME/feltwire/flights or ~/.local/state/feltwire/flights");
  app.add_option("--view", values.view, "FILE.csv for what an observer sees (docs/devices.md)");
  app.add_option("--link", values.link,
                 "Emulate a bad network: a profile such as wifi, or numbers such as "
                 "delay=25,jitter=5,loss=10 (see below)");
  app.footer(link_help() +
             "\nCommands, each with its own --help:\n"
             "  admin      list the sessions of a running server, and change it (docs/admin.md)\n"
             "  devices    list the connected devices, and their problems (docs/devices.md)\n"
             "  identify   measure a device's damping, friction and mass (docs/devices.md)");
  app.add_option("--changes", values.changes,
                 "Changes of this client that an admin of the server may make while it runs "
                 "(docs/admin.md). none; safe: the emulated link, and bounding methods that are "
                 "passive by themselves; any: every method, also none, for a device that nobody "
                 "holds")
      ->capture_default_str();
  app.add_flag("--fixed", values.fixed, "As --changes none");
  app.add_option("--dscp", values.dscp,
                 "DSCP mark of the datagrams: cs0 to cs7, af11 to af43, ef, va or 0 to 63. The "
                 "server sets its own")
      ->capture_default_str();
  app.add_option("--name", options.name, "Name of this client in the server")
      ->capture_default_str();

  app.add_option("--reconnect", options.patience,
                 "[s] How long the client tries to reconnect after it has lost its session, before "
                 "it gives up. 0: it does not try")
      ->capture_default_str();

  app.add_option("--busy-poll", options.busy_poll,
                 "[us] Poll for this time before a reply or a deadline, and do not sleep. inf: "
                 "never sleep, which takes a whole core")
      ->capture_default_str();

  const auto session = "Session";
  app.add_option(
         "--spec", values.spec,
         "The device's specification: " + joined_names(builtin_devices(), "|", &DeviceSpec::name) +
             ", or FILE.json. When not given: the specification from the device itself, else that "
             "of its kind")
      ->group(session);
  app.add_option("--damping", values.damping,
                 "[N s/m] Damping of the device, in place of the specification's: B, or BX,BY,BZ")
      ->delimiter(',')
      ->group(session);
  app.add_option("--mass", values.mass,
                 "[kg] Lower bound of the handle's mass in every direction, in place of the "
                 "specification's")
      ->group(session);
  app.add_flag_callback("--list-specs", list_specs,
                        "Print the built-in specifications, each number with its source, and end");
  app.add_option("--mode", values.mode,
                 "Energy bound: " + bounding_method_choices() +
                     ". When not given: " + std::string(kSessionMethod) +
                     "; with --bounding server or both: " + std::string(kDefaultMethod))
      ->group(session);
  app.add_option("--projection", values.projection,
                 "For contact_frame: " + joined_names(kProjectionNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--storage", values.storage, "For contact_frame: " + joined_names(kStorageNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--reference", values.reference,
                 "For passivity_control*: " + joined_names(kPassivityReferenceNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--coupling-stiffness", parameters.coupling_stiffness,
                 "[N/m] For virtual_coupling. When not given: the largest passive stiffness")
      ->group(session);
  app.add_option("--coupling-damping", parameters.coupling_damping,
                 "[N s/m] For virtual_coupling. When not given: the largest allowed damping")
      ->group(session);
  app.add_option("--tool-mass", parameters.tool_mass, "[kg] For virtual_coupling: mass of its tool")
      ->capture_default_str()
      ->group(session);
  app.add_option("--bounding", values.side,
                 "Where the bound runs: " + joined_names(kBoundingSideNames) +
                     "; client when not given (virtual_coupling and passivity_control_parallel: "
                     "server)")
      ->group(session);
  app.add_option("--rate", values.rate,
                 "[Hz] Rate of the servo loop, if the device does not set it")
      ->capture_default_str()
      ->group(session);
  app.add_option("--redundancy", parameters.redundancy,
                 "Number of earlier samples that each datagram repeats")
      ->capture_default_str()
      ->group(session);
  app.add_option("--operator-damping", parameters.operator_damping,
                 "[N s/m] Damping that the operator's hand is known to add. The bound relies on "
                 "it; the account after the bound never does")
      ->capture_default_str()
      ->group(session);
  app.add_option("--hold-time", values.hold_time,
                 "[s] A command that is older than half of this time fades. At the full time it is "
                 "zero. At least five servo periods. When not given: " +
                     short_text(SessionParameters{}.hold_time) +
                     ", or five servo periods if longer")
      ->group(session);
  app.add_option("--longest-hold-time", values.longest_hold_time,
                 "[s] The server may lengthen the hold time up to this, as servers with a profile "
                 "do. When not given: not beyond --hold-time")
      ->group(session);
  app.add_flag_function(
         "--local-model,!--no-local-model",
         [&values](std::int64_t times) { values.local_model = times > 0; },
         "Ask for a local model: replies have the surfaces near the tool, and the client renders "
         "them at its own rate (docs/network.md). Not with --bounding server. When not given: only "
         "with the modes that shape")
      ->group(session);

  app.add_flag_function(
         "--whole-surfaces,!--no-whole-surfaces",
         [&values](std::int64_t times) { values.whole_surfaces = times > 0; },
         "For the local model, fetch the meshes of the scene, or the body of the tool with the "
         "solids, and feel them as the scene does (docs/network.md). With --no-whole-surfaces "
         "replies have patches or planes of them only")
      ->group(session);

  app.add_flag_function(
         "--rehearsal,!--no-rehearsal",
         [&values](std::int64_t times) { values.rehearses = times > 0; },
         "Say beside the run what a hand will feel, by simulated presses on walls with the law of "
         "this session (docs/devices.md)")
      ->group(session);

  const auto traffic = "Traffic (docs/network.md)";
  app.add_option("--profile", values.profile,
                 "Kind of line to the server, " + network_profile_names() +
                     ": it sets the options of the traffic (docs/lab/trade.md). Options of the "
                     "command line override it")
      ->group(traffic);
  app.add_option("--packet-rate", values.packet_rate,
                 "[Hz] Datagrams to the server, at most --rate. The interval is a whole number of "
                 "servo ticks. When not given: one datagram a tick")
      ->group(traffic);
  app.add_option(
         "--batch", parameters.batch,
         "Samples in each datagram, evenly spaced. Batch and redundancy are together at most 9")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--position-deadband", values.position_deadband_percent,
                 "[%] 0 to 50: send a sample only if it changes the force by more than this. 0: "
                 "send all")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--force-deadband", values.force_deadband_percent,
                 "[%] 0 to 50: the server answers only if the force has changed by more than "
                 "this. 0: it always answers")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--predictor", values.predictor,
                 "What a deadband compares with: " + joined_names(kPredictorNames) +
                     ", the value sent last, or the line through the values sent last")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--keep-alive", parameters.keep_alive, "[s] Longest silence of either deadband")
      ->capture_default_str()
      ->group(traffic);

  std::vector<std::string_view> reducible;
  for (const BoundingMethod* method : bounding_methods())
    if (method->admits_reduction) reducible.push_back(method->name);
  const std::string safety = "Safety (--slew, --ramp-up, --velocity-limit: for the modes " +
                             joined_names(reducible, ", ") + ")";
  // The usual values depend on the mode, so the help names them in words.
  const SafetyLimits usual = protect_hand({}).safety;
  SessionParameters unbounded;
  unbounded.mode = kUnbounded;
  app.add_option(
         "--wait-for-small-force", values.wait_for_small_force,
         "[N] Safety at the start: until the scene has commanded no more than this force "
         "once, the hand feels only the part above the smallest force so far. inf: off. Usually " +
             short_text(usual.force.small))
      ->group(safety);
  app.add_option("--ramp-up", values.ramp_up,
                 "[s] Time from the first contact to the full force. Usually 0, and " +
                     short_text(protect_hand(unbounded).safety.ramp_up) +
                     " if this side does not bound")
      ->group(safety);
  app.add_option("--velocity-limit", values.velocity_limit,
                 "[m/s] Above this speed the force falls, to zero at twice the speed. inf: never. "
                 "Usually " +
                     short_text(usual.force.speed))
      ->group(safety);
  app.add_option("--slew", options.servo.safety.force.slew,
                 "[N/s] Largest rate at which the force may rise. When not given: no limit")
      ->group(safety);
  app.add_option("--max-force", options.servo.safety.force.max,
                 "[N] Largest force, if it is less than that of the device")
      ->group(safety);
  app.add_option("--let-go-after", values.let_go_after,
                 "[s] While a force is on the hand, let the device go for good if the servo makes "
                 "no tick for this time. At most --hold-time, at least two servo periods. When not "
                 "given: five servo periods, 20 without real-time scheduling; the hold time for a "
                 "device that nobody holds")
      ->group(safety);
  app.add_option("--tool-weight", values.tool_weight,
                 "Weight of a tool at the handle, which a constant force along the device's z "
                 "holds: 0.05kg or 0.5N (docs/devices.md)")
      ->group(safety);
  app.add_option("--emergency-button", values.emergency_button,
                 "Number of a button of the device, from 1, which takes all force off at once, as "
                 "the space bar does in the terminal. Key r starts again")
      ->group(safety);
  app.add_option("--await-still", values.await_still,
                 "[s] No force before the hand was still for this time, or its enabling switch is "
                 "pressed. 0: no wait. Usually 0.25 for a device that a person holds")
      ->group(safety);
  app.add_flag("--learn-hand-force", options.servo.learns_hand_force,
               "The account relies on 1.5 times the largest recent hand force, "
               "if that is less than the device's hand_force")
      ->group(safety);
  app.add_flag(
         "!--no-account", options.servo.account,
         "No energy account behind the mode: the law of a paper as it was published. Not "
         "with shaped, midpoint and credited, nor with --operator-damping, nor with --bounding "
         "server")
      ->group(safety);

  const auto hand = "Simulated hand";
  app.add_option("--press-button", values.press,
                 "[s] Time at which the hand presses its only button, number 1, for 0.1 s. It lets "
                 "its enabling switch go 0.5 s before, and holds it again 0.5 s after")
      ->group(hand);
  app.add_option("--path", values.path, "Movement of the hand: " + joined_names(kHandPathNames))
      ->capture_default_str()
      ->group(hand);
  app.add_option(
         "--wrist", values.wrist,
         "Rotation of the hand, if --spec senses rotation: " + joined_names(kWristPathNames))
      ->capture_default_str()
      ->group(hand);
  app.add_option("--wrist-angle", values.wrist_angle, "[rad] How far the hand turns")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--center", values.center,
                 "X,Y,Z [m] The point on the surface (orbit: centre of the circle). When not "
                 "given: from the scene, else 0,0,0")
      ->delimiter(',')
      ->group(hand);
  app.add_option(
         "--normal", values.normal,
         "X,Y,Z Outward normal of the surface there. When not given: from the scene, else 0,0,1")
      ->delimiter(',')
      ->group(hand);
  app.add_option("--radius", task.radius, "[m] Amplitude of the movement along the surface")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--frequency", task.frequency, "[Hz] Frequency of the movement")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--depth", task.depth, "[m] Intended depth of the hand below the surface")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--lead-in", task.lead_in, "[s] Time until the hand reaches its depth")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--tremor", task.tremor, "[m] RMS of the tremor on each axis, 8 to 12 Hz")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--seed", task.seed, "Seed of the tremor")->capture_default_str()->group(hand);

  const auto mapping = "Workspace of the device in the scene (docs/devices.md)";
  app.add_option("--map-scale", values.map_scale,
                 "Metres that the tool moves for one metre of the hand, 0.01 to 100. The hand gets "
                 "the scene's force times this")
      ->capture_default_str()
      ->group(mapping);
  app.add_option("--map-rotate", values.map_rotate,
                 "X,Y,Z [deg] Turns the device's axes about this direction by the vector's length: "
                 "0,0,90 makes its x the scene's y")
      ->delimiter(',')
      ->group(mapping);
  app.add_option("--map-translate", values.map_translate,
                 "X,Y,Z [m] Place in the scene of the middle of the device's workspace")
      ->delimiter(',')
      ->group(mapping);
  app.add_option("--map-mirror", values.map_mirror,
                 "x, y or z: this axis of the device is reversed")
      ->group(mapping);

  const auto steering = "Gamepad and 3D mouse";
  SteeringOptions& steered = options.device.steering;
  app.add_option("--steer-speed", steered.speed,
                 "[m/s] Speed of the tool at full deflection, in every direction")
      ->capture_default_str()
      ->group(steering);
  app.add_option("--steer-turn", steered.turn, "[rad/s] Speed of its turning at full deflection")
      ->capture_default_str()
      ->group(steering);
  app.add_option("--dead-zone", steered.dead_zone,
                 "Share of an axis's range that counts as rest, 0 to 0.5. The kernel's dead zone "
                 "is used if it is larger")
      ->capture_default_str()
      ->group(steering);

  const Variables variables{.program = "client",
                            .shared = credential_variables(),
                            .ending = {"list", "list-specs", "check"}};
  try {
    read_environment(app, argc, argv, variables, client_rivals());
    app.parse(argc, argv);
    if (!values.profile.empty()) {
      apply_profile(network_profile(values.profile), values, parameters);
      app.parse(argc, argv);
    }
    to_client_options(values, task, options);
  } catch (const CLI::ParseError& error) {
    return exit_with(app, error, short_help()) == 0 ? 0 : kUsageError;
  } catch (const std::invalid_argument& error) {
    std::cerr << "feltwire-client: " << visible(error.what()) << "\n";
    return kUsageError;
  }
  return options;
}

}  // namespace feltwire
