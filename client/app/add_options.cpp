#include "client/app/add_options.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/enum_names.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/session/profiles.hpp"

namespace feltwire {
namespace {

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

constexpr std::array<std::string_view, 3> kLocalModelNames = {"off", "patches", "whole"};

std::string local_model_complaint(const std::string& value) {
  if (find_named(kLocalModelNames, value) != nullptr) return {};
  return "'" + value + "' is none of " + joined_names(kLocalModelNames, ", ");
}

void add_run_options(CLI::App& app, OptionValues& values, ClientOptions& options) {
  app.add_option("--config", values.config,
                 "FILE.json with options: {\"rate\": 500}. The command line and the "
                 "environment override it (docs/devices.md)");
  app.add_option("--connect", values.connect,
                 "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required(values.has_server);
  add_credential_options(app, values.credentials);
  app.add_flag("--list", options.list, "List the server's scenes and exit");
  app.add_flag("--check", options.check,
               "Test for ten seconds if this machine and the network can run a session, and exit. "
               "The test uses a simulated hand that touches nothing (docs/troubleshooting.md)");
  app.add_option("--scene", values.scene, "Name of the scene to join");
  app.add_option("--tool", options.tool,
                 "Name of the tool to hold. Default: the scene's first tool");
  app.add_option("--role", values.role,
                 "operator, pointer (a small hand) or observer (watches, without force and "
                 "movement). The token must allow the role")
      ->capture_default_str();
  app.add_option(
         "--device", values.device.kind,
         "KIND or KIND:NAME, and settings: KIND:KEY=VALUE,... or KIND:NAME,KEY=VALUE,... (see "
         "below). " +
             driver_choices())
      ->capture_default_str();
  app.add_option(
      "--lead", values.lead,
      "[s] Lead the scene's robot and feel its contacts (docs/teleoperation.md). A simulated or "
      "recorded hand holds the enabling switch from this time on. At least 0.2");
  app.add_option("--robot", options.robot,
                 "Name of the seat of the robot to lead. Default: the scene's first seat");
  app.add_option("--trust-robot", values.trust,
                 "J,W Energy per contact [J], and power over time [W], that the client accepts "
                 "from your own robot (docs/teleoperation.md). Default: none")
      ->delimiter(',');
  app.add_option("--duration", options.duration,
                 "[s] Length of the run. 0: run until it is stopped or the replayed recording ends")
      ->capture_default_str();
  app.add_option("--report", values.files.report,
                 "FILE.json for the results of the run (docs/devices.md)");
  app.add_option("--record", values.files.record,
                 "FILE.csv or FILE.mcap for a recording of every servo tick (docs/recording.md)");
  app.add_option("--record-max-mib", values.files.record_limits.mebibytes,
                 "[MiB] Largest size of one file of an MCAP recording. The next files are "
                 "FILE-0001.mcap, FILE-0002.mcap");
  app.add_option("--record-max-seconds", values.files.record_limits.seconds,
                 "[s] Longest time in one file of an MCAP recording. Then the next file begins");
  app.add_option(
      "--flight-recorder", values.files.flight_recorder,
      "Folder for a recording of the last ten seconds. The client writes it after an error, a lost "
      "session, a device fault, an overdrawn energy account, and at SIGUSR1. off: write none. "
      "Default: $XDG_STATE_HOME/feltwire/flights or ~/.local/state/feltwire/flights");
  app.add_option("--view", values.files.view,
                 "FILE.csv for the scene states that an observer receives (docs/devices.md)");
  app.add_option("--link", values.link,
                 "Emulate a network: a profile such as wifi, or numbers such as "
                 "delay=25,jitter=5,loss=10 (see below)");
  app.add_option(
         "--changes", values.changes,
         "Changes that an admin of the server may make to this running client (docs/admin.md). "
         "none: no change. safe: the emulated link, and bounding methods that are passive by "
         "themselves. any: the link and every method, for a device that nobody holds")
      ->capture_default_str();
  app.add_option("--dscp", values.dscp,
                 "DSCP mark of the client's datagrams: cs0 to cs7, af11 to af43, ef, va or 0 to 63")
      ->capture_default_str();
  app.add_option("--name", options.name, "Name of this client at the server")
      ->capture_default_str();

  app.add_option("--reconnect", options.patience,
                 "[s] Try to reconnect for this time after a lost session. 0: do not try")
      ->capture_default_str();

  app.add_option("--busy-poll", options.busy_poll,
                 "[us] Poll, instead of sleeping, for this time before a reply or a deadline. inf: "
                 "never sleep. This uses a whole core")
      ->capture_default_str();
}

void add_session_options(CLI::App& app, OptionValues& values) {
  const auto session = "Session";
  app.add_option(
         "--spec", values.device.spec,
         "Specification of the device: " + joined_names(builtin_devices(), "|", &DeviceSpec::name) +
             ", or FILE.json. Default: the specification from the device, else the specification "
             "of its kind")
      ->group(session);
  app.add_option("--mode", values.mode.method,
                 "METHOD of the energy bound, and settings: METHOD,KEY=VALUE,... or KEY=VALUE,... "
                 "(see below). " +
                     bounding_method_choices() + ". Default: " + std::string(kSessionMethod) +
                     ". Default with side=server or side=both: " + std::string(kDefaultMethod))
      ->group(session);
  app.add_option("--traffic", values.traffic.words,
                 "Network to the server, " + network_profile_names() +
                     ", and settings: PROFILE,KEY=VALUE,... or KEY=VALUE,... (see below; "
                     "docs/network.md, docs/lab/trade.md). The settings override the profile")
      ->group(session);
  app.add_option("--rate", values.rate,
                 "[Hz] Rate of the servo loop, unless the device sets the rate")
      ->capture_default_str()
      ->group(session);
  app.add_option("--hold-time", values.limits.hold_time,
                 "[s] Age at which the force of a reply is zero. The force fades from half this "
                 "age on. At least five servo periods. Default: " +
                     short_text(SessionParameters{}.hold_time) +
                     ", or five servo periods if that is longer")
      ->group(session);
  app.add_option("--longest-hold-time", values.limits.longest_hold_time,
                 "[s] Longest hold time that the client accepts. Servers with a profile may "
                 "lengthen the hold time. Default: --hold-time")
      ->group(session);
  app.add_option("--local-model", values.local_model,
                 "Surfaces near the tool that the client renders at its own rate "
                 "(docs/network.md): " +
                     joined_names(kLocalModelNames) +
                     ". patches: replies contain patches or planes near the tool. whole: the "
                     "client also fetches the whole meshes of the scene, or the tool's body and "
                     "the solids. Not with side=server. Default: whole for the methods shaped, "
                     "midpoint and credited, or if the profile of --traffic requests it; else off")
      ->check(local_model_complaint)
      ->group(session);
  app.add_flag_function(
         "--rehearsal,!--no-rehearsal",
         [&values](std::int64_t times) { values.rehearses = times > 0; },
         "Simulate presses on walls with the law of this session, and print what a hand will feel "
         "(docs/devices.md)")
      ->group(session);
}

void add_safety_options(CLI::App& app, OptionValues& values, ClientOptions& options) {
  std::vector<std::string_view> reducible;
  for (const BoundingMethod* method : bounding_methods())
    if (method->admits_reduction) reducible.push_back(method->name);
  const std::string safety = "Safety (--slew, --ramp-up, --velocity-limit: for the modes " +
                             joined_names(reducible, ", ") + ")";
  // The defaults depend on the mode, so the help describes them in words.
  const SafetyLimits usual = protect_hand({}).safety;
  SessionParameters unbounded;
  unbounded.mode = kUnbounded;
  app.add_option(
         "--wait-for-small-force", values.limits.wait_for_small_force,
         "[N] The full force starts only after the scene has commanded this force or less. Until "
         "then the hand feels only the part above the smallest force so far. inf: off. Default: " +
             short_text(usual.force.small))
      ->group(safety);
  app.add_option("--ramp-up", values.limits.ramp_up,
                 "[s] Time from the first contact to the full force. Default: 0, or " +
                     short_text(protect_hand(unbounded).safety.ramp_up) +
                     " if the client does not bound")
      ->group(safety);
  app.add_option("--velocity-limit", values.limits.velocity_limit,
                 "[m/s] The force falls above this speed, and is zero at twice this speed. inf: "
                 "off. Default: " +
                     short_text(usual.force.speed))
      ->group(safety);
  app.add_option("--slew", options.servo.safety.force.slew,
                 "[N/s] Largest rise rate of the force. Default: no limit")
      ->group(safety);
  app.add_option("--max-force", options.servo.safety.force.max,
                 "[N] Largest force on the hand. The device's own limit applies if it is smaller")
      ->group(safety);
  app.add_option(
         "--let-go-after", values.limits.let_go_after,
         "[s] Release the device, until the end of the run, if the servo stalls for this time "
         "under force. At least two servo periods, at most --hold-time. Default: five servo "
         "periods; 20 without real-time scheduling; --hold-time for a device that nobody holds")
      ->group(safety);
  app.add_flag("--learn-hand-force", options.servo.learns_hand_force,
               "The energy account uses 1.5 times the largest recent hand force, if that is less "
               "than the device's hand_force")
      ->group(safety);
}

}  // namespace

void add_options(CLI::App& app, OptionValues& values, ClientOptions& options) {
  add_run_options(app, values, options);
  add_session_options(app, values);
  add_safety_options(app, values, options);
}

}  // namespace feltwire
