#include "client/app/options.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include "client/app/credential_options.hpp"
#include "client/run/output_files.hpp"
#include "core/base/choice.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"
#include "core/command_line/environment.hpp"
#include "core/command_line/suggestion.hpp"
#include "core/device/device_file.hpp"
#include "protocol/net/busy_poll.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/session/profiles.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {
namespace {

constexpr int kUsageError = 2;
constexpr double kLongestDuration = 1e7;  // [s] some four months
constexpr std::string_view kReplay = "replay:";

/// The command line as it is written, before its words are understood.
struct WrittenOptions {
  std::string connect, scene, device = "simulated", spec = "simulated";
  std::string mode = SessionParameters{}.mode,
              projection = std::string(name(SessionParameters{}.projection)), storage = "minimal",
              reference = "zero", side, path = "press", predictor = "level";
  double rate = 1000.0;
  std::optional<double> packet_rate;  // [Hz]
  double position_deadband_percent = 0.0, force_deadband_percent = 0.0;
  std::optional<std::array<double, 3>> center, normal;
  std::optional<double> wait_for_small_force, ramp_up, velocity_limit;
  std::string report, record, view, link, profile, dscp = "cs0", role = "operator";
  CredentialOptions credentials;
};

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

Vec3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

void require(bool good, const char* message) {
  if (!good) throw std::invalid_argument(message);
}

/// Sets the safety limits that the command line does not give to values that protect the hand, as
/// far as the bounding mode allows.
void choose_safety(const WrittenOptions& words, ClientOptions& options) {
  SafetyLimits& given = options.servo.safety;
  const SafetyLimits usual = protect_hand(options.parameters).safety;
  given.force.small = words.wait_for_small_force.value_or(usual.force.small);
  given.torque.small = std::isfinite(given.force.small) ? usual.torque.small : given.force.small;
  given.force.speed = words.velocity_limit.value_or(usual.force.speed);
  given.ramp_up = words.ramp_up.value_or(usual.ramp_up);
}

double period_of(const WrittenOptions& words) {
  require(std::isfinite(words.rate) && words.rate > 0.0, "--rate must be above 0 Hz");
  return 1.0 / words.rate;
}

/// Begins with what a profile says; the command line is then read once more, and wins. Throws
/// std::invalid_argument.
void begin_with(const NetworkProfile& line, WrittenOptions& words, SessionParameters& parameters) {
  constexpr double kPercent = 100.0;
  parameters = {};
  parameters.mode = bounding_method(words.mode).name;
  parameters.servo_period = period_of(words);
  parameters = over(line, parameters);
  words.position_deadband_percent = kPercent * parameters.position_deadband;
  words.force_deadband_percent = kPercent * parameters.force_deadband;
  words.predictor = name(parameters.predictor);
}

/// [Hz] of datagrams to the server, if not one a tick. Who only looks does so at the rate of
/// pictures, unless told otherwise.
std::optional<double> packet_rate(const WrittenOptions& words, Role role) {
  constexpr double kPictures = 100.0;
  const bool usual = !words.packet_rate && words.profile.empty();
  return usual && role == Role::observer ? std::min(kPictures, words.rate) : words.packet_rate;
}

/// How often what travels. Throws std::invalid_argument.
void choose_traffic(const WrittenOptions& words, std::optional<double> rate,
                    SessionParameters& parameters) {
  constexpr double kPercent = 0.01;
  parameters.position_deadband = kPercent * words.position_deadband_percent;
  parameters.force_deadband = kPercent * words.force_deadband_percent;
  parameters.predictor = predictor(words.predictor);
  if (!rate) return;
  require(*rate > 0.0 && *rate <= words.rate,
          "--packet-rate must be above 0 Hz and at most --rate");
  // Never more often than was asked for. A rounded rate still gives whole ticks: 1000 / 333.4 is 3.
  constexpr double kRounded = 1e-3;
  const double ticks = std::ceil(words.rate / *rate - kRounded);
  require(ticks <= kMaxPacketInterval, "--packet-rate must be at least --rate / 1000");
  parameters.packet_interval = std::max(1, static_cast<int>(ticks));
}

/// Those that an option names.
std::vector<NamedFile> named(std::vector<NamedFile> files) {
  std::erase_if(files, [](const NamedFile& file) { return file.path.empty(); });
  return files;
}

std::vector<NamedFile> written_files(const WrittenOptions& words) {
  return named({{"--report", words.report}, {"--record", words.record}, {"--view", words.view}});
}

std::vector<NamedFile> read_files(const WrittenOptions& words) {
  const CredentialOptions& c = words.credentials;
  const bool replays = words.device.starts_with(kReplay);
  return named({{"--device", replays ? words.device.substr(kReplay.size()) : std::string()},
                {"--fingerprint-file", c.fingerprint_file},
                {"--ca", c.ca},
                {"--certificate", c.certificate},
                {"--key", c.key},
                {"--token-file", c.token_file}});
}

/// Throws std::invalid_argument where the server would refuse the name without saying which.
void check_name(const char* option, const std::string& name) {
  if (name.size() <= control::kMaxName) return;
  throw std::invalid_argument(std::string(option) + ": the name has " +
                              std::to_string(name.size()) + " bytes; at most " +
                              std::to_string(control::kMaxName) + " can be sent");
}

/// Throws std::invalid_argument.
void understand(const WrittenOptions& words, HandTask task, ClientOptions& options) {
  options.server = {parse_endpoint(words.connect), credentials(words.credentials)};
  if (options.list) return;
  require(!words.scene.empty(), "--scene is required; --list shows the scenes there are");
  options.scene = words.scene;
  check_name("--scene", options.scene);
  check_name("--tool", options.tool);
  check_name("--name", options.name);
  require(options.duration >= 0.0 && options.duration <= kLongestDuration,
          "--duration must be from 0 to 1e7 s; 0 runs until it is stopped");
  require(options.patience >= 0.0 && options.patience <= kLongestDuration,
          "--reconnect must be from 0 to 1e7 s; 0 ends when the session is lost");

  require(possible_busy_poll(options.busy_poll),
          "--busy-poll must be from 0 to 1e6 us, or inf: never sleep");

  options.role = role(words.role);
  require(options.role != Role::admin, "--role must be operator or observer");
  require(words.view.empty() || options.role == Role::observer,
          "--view is of observers; give --role observer, too");
  options.parameters.mode = bounding_method(words.mode).name;
  options.parameters.projection = projection(words.projection);
  options.parameters.storage = storage(words.storage);
  options.parameters.reference = passivity_reference(words.reference);
  if (!words.side.empty())
    options.parameters.side = bounding_side(words.side);
  else if (bounding_method(options.parameters.mode).moves_probe)
    options.parameters.side = BoundingSide::server;
  options.parameters.servo_period = period_of(words);
  choose_traffic(words, packet_rate(words, options.role), options.parameters);
  validate(options.parameters);
  choose_safety(words, options);
  validate(options.servo, options.parameters);

  options.spec = device_spec(words.spec);
  options.device_kind = words.device;
  if (words.device == "simulated") {
    task.path = hand_path(words.path);
    if (words.center) task.center = vector(*words.center);
    if (words.normal) set_normal(task, vector(*words.normal));
    options.center_given = words.center.has_value();
    options.normal_given = words.normal.has_value();
    options.device = task;
  } else if (words.device.starts_with(kReplay) && words.device.size() > kReplay.size()) {
    options.device = ReplayFile{words.device.substr(kReplay.size())};
  } else {
    throw std::invalid_argument("unknown device '" + words.device +
                                "'; use simulated or replay:FILE.csv");
  }
  if (!words.report.empty()) options.report = words.report;
  if (!words.record.empty()) options.record = words.record;
  if (!words.view.empty()) options.view = words.view;
  require_different(written_files(words), read_files(words));
  options.dscp = dscp(words.dscp);
  if (!words.link.empty()) options.link = parse_link(words.link);
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
  app.add_option("--record", words.record, "FILE.csv that gets every tick");
  app.add_option("--view", words.view,
                 "FILE.csv that gets what an observer sees (docs/devices.md)");
  app.add_option("--link", words.link,
                 "Try a bad network: a profile, e.g. wifi, or e.g. delay=25,jitter=5,loss=10 (see "
                 "below)");
  app.footer(link_help());
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
  app.add_option("--mode", words.mode, "Energy bound: " + bounding_method_choices())
      ->capture_default_str()
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
                 "[N s/m] that the operator's hand is known to add, credited to the bound")
      ->capture_default_str()
      ->group(session);
  app.add_option("--hold-time", parameters.hold_time,
                 "[s] a command older than half of it fades, at all of it it is zero")
      ->capture_default_str()
      ->group(session);
  app.add_flag("--local-model", parameters.local_model,
               "Replies bring the surfaces near the tool, and this side renders them at its own "
               "rate (docs/network.md); not with --bounding server")
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
