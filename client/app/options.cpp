#include "client/app/options.hpp"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <sstream>
#include <string_view>

#include "client/app/written_options.hpp"
#include "core/base/choice.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"
#include "core/command_line/environment.hpp"
#include "core/command_line/suggestion.hpp"
#include "protocol/session/profiles.hpp"

namespace feltwire {
namespace {

constexpr int kUsageError = 2;

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

std::variant<ClientOptions, int> parse_options(int argc, char** argv) {
  ClientOptions options;
  SessionParameters& parameters = options.parameters;
  HandTask task;
  WrittenOptions words;

  CLI::App app{
      "feltwire-client: a haptic device, simulated or replayed, in a scene of a feltwire server."};
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "feltwire-client: " + visible(error.what() + suggestion(*failed)) + "; see --help\n";
  });
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-client"); },
      "Say version, commit, compiler and kind of build");
  app.add_option("--connect", words.connect,
                 "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required();
  add_credential_options(app, words.credentials);
  app.add_flag("--list", options.list, "List the server's scenes and end");
  app.add_flag("--check", options.check,
               "Ten seconds with a simulated hand that touches nothing: is this machine, and the "
               "network, fit for a session? (docs/troubleshooting.md)");
  app.add_option("--scene", words.scene, "Name of the scene to join");
  app.add_option("--tool", options.tool,
                 "Name of the tool to hold, of those that the scene has; its first when not given");
  app.add_option("--role", words.role,
                 "operator, or observer: feels nothing, moves nothing and is shown the scene; what "
                 "the token is for")
      ->capture_default_str();
  app.add_option("--device", words.device,
                 "simulated, or replay:FILE.csv (columns t,x,y,z and optionally qw,qx,qy,qz)")
      ->capture_default_str();
  app.add_option("--duration", options.duration,
                 "[s] how long; 0 runs until stopped or the recording is over")
      ->capture_default_str();
  app.add_option("--report", words.report,
                 "FILE.json that gets the run's numbers (docs/devices.md)");
  app.add_option("--record", words.record,
                 "FILE.csv or FILE.mcap that gets every tick (docs/recording.md)");
  app.add_option("--record-max-mib", words.record_limits.mebibytes,
                 "[MiB] of each file of an MCAP recording; the files are FILE-0001.mcap and so on");
  app.add_option("--record-max-seconds", words.record_limits.seconds,
                 "[s] that each file of an MCAP recording lasts, likewise");
  app.add_option("--flight-recorder", words.flight_recorder,
                 "Folder that gets the last ten seconds where the run ends with an error, or its "
                 "account was overdrawn");
  app.add_option("--view", words.view,
                 "FILE.csv that gets what an observer sees (docs/devices.md)");
  app.add_option("--link", words.link,
                 "Try a bad network: a profile, e.g. wifi, or e.g. delay=25,jitter=5,loss=10 (see "
                 "below)");
  app.footer(link_help() +
             "\nCommands, with a --help of their own:\n"
             "  admin   look at a server that runs, and change it (docs/admin.md)");
  app.add_option("--dscp", words.dscp,
                 "Mark of the datagrams for the network: cs0 to cs7, af11 to af43, ef, va or 0 to "
                 "63 (the server marks its own)")
      ->capture_default_str();
  app.add_option("--name", options.name, "What the server calls this client")
      ->capture_default_str();

  app.add_option("--reconnect", options.patience,
                 "[s] to look for a lost session, or a new one, before giving up; 0: not at all")
      ->capture_default_str();

  app.add_option("--busy-poll", options.busy_poll,
                 "[us] to look busily for the reply, and for the next deadline, instead of "
                 "sleeping; inf: never sleep, which takes a core")
      ->capture_default_str();

  const auto session = "Session";
  app.add_option("--spec", words.spec,
                 "The device's specification: " +
                     choices(builtin_devices(), "|", &DeviceSpec::name) + ", or FILE.json")
      ->capture_default_str()
      ->group(session);
  app.add_option("--mode", words.mode,
                 "Energy bound: " + bounding_method_choices() +
                     ". When not given: " + std::string(kSessionMethod) +
                     ", with --bounding server or both " + std::string(kDefaultMethod))
      ->group(session);
  app.add_option("--projection", words.projection, "Of contact_frame: " + choices(kProjectionNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--storage", words.storage, "Of contact_frame: " + choices(kStorageNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--reference", words.reference,
                 "Of passivity_control*: " + choices(kPassivityReferenceNames))
      ->capture_default_str()
      ->group(session);
  app.add_option("--coupling-stiffness", parameters.coupling_stiffness,
                 "[N/m] of virtual_coupling; the stiffest that is passive when not given")
      ->group(session);
  app.add_option("--coupling-damping", parameters.coupling_damping,
                 "[N s/m] of virtual_coupling; all that is allowed when not given")
      ->group(session);
  app.add_option("--tool-mass", parameters.tool_mass, "[kg] of virtual_coupling's tool")
      ->capture_default_str()
      ->group(session);
  app.add_option("--bounding", words.side,
                 "Where the bound runs: " + choices(kBoundingSideNames) +
                     "; client when not given (virtual_coupling and passivity_control_parallel: "
                     "server)")
      ->group(session);
  app.add_option("--rate", words.rate, "[Hz] of the servo loop")
      ->capture_default_str()
      ->group(session);
  app.add_option("--redundancy", parameters.redundancy, "Earlier samples repeated in each datagram")
      ->capture_default_str()
      ->group(session);
  app.add_option("--operator-damping", parameters.operator_damping,
                 "[N s/m] that the operator's hand is known to add: the bound counts on it, the "
                 "account behind it never does")
      ->capture_default_str()
      ->group(session);
  app.add_option("--hold-time", parameters.hold_time,
                 "[s] a command older than half of it fades, at all of it it is zero")
      ->capture_default_str()
      ->group(session);
  app.add_flag_function(
         "--local-model,!--no-local-model",
         [&words](std::int64_t times) { words.local_model = times > 0; },
         "Replies bring the surfaces near the tool, and this side renders them at its own rate "
         "(docs/network.md); not with --bounding server. When not given: with the modes that shape")
      ->group(session);

  const auto traffic = "Traffic (docs/network.md)";
  app.add_option("--profile", words.profile,
                 "Of the line to the server, " + network_profile_names() +
                     ": how often what travels (docs/lab/trade.md); options given beside it win")
      ->group(traffic);
  app.add_option(
         "--packet-rate", words.packet_rate,
         "[Hz] of datagrams to the server, at most --rate, in whole servo ticks; a datagram a "
         "tick when not given")
      ->group(traffic);
  app.add_option("--batch", parameters.batch,
                 "Samples of each datagram, evenly spaced; with the redundancy at most 9")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--position-deadband", words.position_deadband_percent,
                 "[%] 0 to 50: send only what makes more than this difference to the force; 0: all")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--force-deadband", words.force_deadband_percent,
                 "[%] 0 to 50: be answered only when the force is off by more than this; 0: always")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--predictor", words.predictor,
                 "What it is off from: " + choices(kPredictorNames) +
                     ", the value sent last or the line through it")
      ->capture_default_str()
      ->group(traffic);
  app.add_option("--keep-alive", parameters.keep_alive, "[s] longest silence of either deadband")
      ->capture_default_str()
      ->group(traffic);

  std::vector<std::string_view> reducible;
  for (const BoundingMethod* method : bounding_methods())
    if (method->admits_reduction) reducible.push_back(method->name);
  const std::string safety =
      "Safety (--slew, --ramp-up, --velocity-limit: of the modes " + choices(reducible, ", ") + ")";
  // Their usual values depend on the mode, so the help names them in words.
  const SafetyLimits usual = protect_hand({}).safety;
  SessionParameters unbounded;
  unbounded.mode = kUnbounded;
  app.add_option(
         "--wait-for-small-force", words.wait_for_small_force,
         "[N] until the scene has once asked for no more, only force beyond its smallest so "
         "far; inf: at once; usually " +
             short_text(usual.force.small))
      ->group(safety);
  app.add_option("--ramp-up", words.ramp_up,
                 "[s] from the first contact to the full force; usually 0, and " +
                     short_text(protect_hand(unbounded).safety.ramp_up) +
                     " where this side does not bound")
      ->group(safety);
  app.add_option("--velocity-limit", words.velocity_limit,
                 "[m/s] a faster device loses its force, all of it at twice this; inf: never; "
                 "usually " +
                     short_text(usual.force.speed))
      ->group(safety);
  app.add_option("--slew", options.servo.safety.force.slew,
                 "[N/s] limit on how fast the force may rise; none when not given")
      ->group(safety);
  app.add_option("--max-force", options.servo.safety.force.max,
                 "[N] where less than the device's own is wanted")
      ->group(safety);
  app.add_flag(
         "--learn-hand-force", options.servo.learns_hand_force,
         "The account counts on the largest force from outside that it saw lately, and a half "
         "more, where that is less than the device's hand_force")
      ->group(safety);

  const auto hand = "Simulated hand";
  app.add_option("--path", words.path, "What it does: " + choices(kHandPathNames))
      ->capture_default_str()
      ->group(hand);
  app.add_option(
         "--center", words.center,
         "X,Y,Z [m] the surface point (orbit: centre of the circle); default: where the scene "
         "says, else the origin")
      ->delimiter(',')
      ->group(hand);
  app.add_option(
         "--normal", words.normal,
         "X,Y,Z outward normal of the surface there; default: as the scene says, else 0,0,1")
      ->delimiter(',')
      ->group(hand);
  app.add_option("--radius", task.radius, "[m] amplitude along the surface")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--frequency", task.frequency, "[Hz] of the movement")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--depth", task.depth, "[m] how far below the surface it means to be")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--tremor", task.tremor, "[m] RMS an axis, 8 to 12 Hz")
      ->capture_default_str()
      ->group(hand);
  app.add_option("--seed", task.seed, "Of the tremor")->capture_default_str()->group(hand);

  read_environment(app);
  try {
    app.parse(argc, argv);
    if (!words.profile.empty()) {
      begin_with(network_profile(words.profile), words, parameters);
      app.parse(argc, argv);
    }
    understand(words, task, options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  } catch (const std::invalid_argument& error) {
    std::cerr << "feltwire-client: " << visible(error.what()) << "\n";
    return kUsageError;
  }
  return options;
}

}  // namespace feltwire
