#include "client/app/session_settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/enum_names.hpp"
#include "core/base/units.hpp"
#include "protocol/command_line/settings.hpp"
#include "protocol/session/profiles.hpp"

namespace feltwire {
namespace {

constexpr std::array<std::string_view, 2> kSwitchNames = {"on", "off"};

void require_session(bool good, const char* message) {
  if (!good) throw std::invalid_argument(message);
}

/// Begins with the values of a network profile.
void apply_profile(const NetworkProfile& line, OptionValues& values,
                   SessionParameters& parameters) {
  parameters.mode =
      values.mode.method.empty() ? kSessionMethod : bounding_method(values.mode.method).name;
  parameters.servo_period = servo_period_of(values);
  parameters = over(line, parameters);
  values.traffic.position_deadband_percent = kPercent * parameters.position_deadband;
  values.traffic.force_deadband_percent = kPercent * parameters.force_deadband;
  values.traffic.predictor = name(parameters.predictor);
}

/// Returns the datagram rate [Hz], or nothing for one datagram per tick.
std::optional<double> packet_rate(const OptionValues& values, Role role) {
  constexpr double kPictures = 100.0;  // [Hz] default of an observer
  const bool usual = !values.traffic.packet_rate && values.traffic.profile.empty();
  return usual && role == Role::observer ? std::min(kPictures, values.rate)
                                         : values.traffic.packet_rate;
}

/// Appends the old options of the settings in `keys`, each with its new spelling.
void append_renamed(Renamed& renamed, const CLI::App& keys, const std::string& option) {
  for (const CLI::Option* key : keys.get_options()) {
    const std::string& name = key->get_lnames().front();
    std::string old = name;
    std::replace(old.begin(), old.end(), '_', '-');
    renamed.push_back({old, option + name + "=..."});
  }
}

}  // namespace

void add_mode_settings(CLI::App& keys, OptionValues& values, ClientOptions& options) {
  SessionParameters& parameters = options.parameters;
  const auto group = "Energy bound (--mode contact_frame,storage=elastic, or --mode side=server)";
  keys.set_help_flag();
  keys.add_option("--side", values.mode.side,
                  "Place of the bound: " + joined_names(kBoundingSideNames) +
                      ". Default: client, but server for virtual_coupling and "
                      "passivity_control_parallel")
      ->group(group);
  keys.add_option("--projection", values.mode.projection,
                  "Projection of contact_frame: " + joined_names(kProjectionNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option("--storage", values.mode.storage,
                  "Energy storage of contact_frame: " + joined_names(kStorageNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option("--operator_damping", parameters.operator_damping,
                  "[N s/m] Known least damping of the operator's hand. The bound uses it. The "
                  "energy account after the bound does not")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--account", values.account,
                  "on, or off: run the method without an energy account after it, as published in "
                  "its paper. Not off with shaped, midpoint, credited, operator_damping or "
                  "side=server")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--reference", values.mode.reference,
                  "Reference of passivity_control*: " + joined_names(kPassivityReferenceNames))
      ->capture_default_str()
      ->group(group);
  keys.add_option("--coupling_stiffness", parameters.coupling_stiffness,
                  "[N/m] Stiffness of virtual_coupling. Default: the largest passive stiffness")
      ->group(group);
  keys.add_option("--coupling_damping", parameters.coupling_damping,
                  "[N s/m] Damping of virtual_coupling. Default: the largest allowed damping")
      ->group(group);
  keys.add_option("--tool_mass", parameters.tool_mass,
                  "[kg] Mass of the simulated tool of virtual_coupling")
      ->capture_default_str()
      ->group(group);
}

void add_traffic_settings(CLI::App& keys, OptionValues& values, SessionParameters& parameters) {
  const auto group = "Traffic (--traffic wan,packet_rate=50, or --traffic force_deadband=10)";
  keys.set_help_flag();
  keys.add_option("--packet_rate", values.traffic.packet_rate,
                  "[Hz] Rate of the datagrams to the server, at most --rate. The interval is a "
                  "whole number of servo ticks. Default: one datagram per tick")
      ->group(group);
  keys.add_option("--batch", parameters.batch,
                  "Number of evenly spaced new samples in each datagram. batch plus redundancy is "
                  "at most 9")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--redundancy", parameters.redundancy,
                  "Number of earlier samples that each datagram repeats")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--position_deadband", values.traffic.position_deadband_percent,
                  "[%] Send a sample only if it changes the force by more than this share, 0 to "
                  "50. 0: send all samples")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--force_deadband", values.traffic.force_deadband_percent,
                  "[%] The server answers only if the force changed by more than this share, 0 to "
                  "50. 0: it always answers")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--predictor", values.traffic.predictor,
                  "Prediction that a deadband compares with: " + joined_names(kPredictorNames) +
                      ". level: the last sent value. linear: the line through the last sent "
                      "values")
      ->capture_default_str()
      ->group(group);
  keys.add_option("--keep_alive", parameters.keep_alive,
                  "[s] Longest time without a datagram while a deadband is active")
      ->capture_default_str()
      ->group(group);
}

void read_mode_settings(CLI::App& keys, OptionValues& values) {
  const std::string method = values.mode.method.substr(0, values.mode.method.find(','));
  if (const std::size_t colon = method.find(':'); colon != std::string::npos)
    throw std::invalid_argument("--mode " + values.mode.method +
                                ": write a comma behind the method: " + method.substr(0, colon) +
                                "," + values.mode.method.substr(colon + 1));
  SettingsText given = split_settings(values.mode.method, keys, SettingsBegin::name, "--mode");
  read_settings(keys, given.settings, "--mode");
  values.mode.method = std::move(given.begin);
}

void read_traffic_settings(CLI::App& keys, OptionValues& values, SessionParameters& parameters) {
  SettingsText given = split_settings(values.traffic.words, keys, SettingsBegin::name, "--traffic");
  values.traffic.profile = std::move(given.begin);
  if (!values.traffic.profile.empty())
    apply_profile(network_profile(values.traffic.profile), values, parameters);
  read_settings(keys, given.settings, "--traffic");
}

double servo_period_of(const OptionValues& values) {
  const double period = 1.0 / values.rate;
  require_session(period >= kShortestServoPeriod && period <= kLongestServoPeriod,
                  "--rate must be from 10 to 100000 Hz");
  return period;
}

void choose_bound(const OptionValues& values, ClientOptions& options) {
  SessionParameters& parameters = options.parameters;
  if (!values.mode.side.empty()) parameters.side = bounding_side(values.mode.side);
  const bool here = parameters.side == BoundingSide::client;
  const std::string_view usual = here ? kSessionMethod : kDefaultMethod;
  parameters.mode = values.mode.method.empty() ? usual : bounding_method(values.mode.method).name;
  const BoundingMethod& method = bounding_method(parameters.mode);
  if (values.mode.side.empty() && stands_beside_scene(method))
    parameters.side = BoundingSide::server;
  parameters.projection = projection(values.mode.projection);
  parameters.storage = storage(values.mode.storage);
  parameters.reference = passivity_reference(values.mode.reference);
  options.servo.account = get_named("value of account", values.account, kSwitchNames) == "on";
  const bool by_profile = !values.traffic.profile.empty() && parameters.local_model;
  parameters.local_model =
      values.local_model.empty() ? by_profile || method.shapes : values.local_model != "off";
  options.whole_surfaces = values.local_model != "patches";
}

void choose_traffic(const OptionValues& values, Role role, SessionParameters& parameters) {
  static_assert(kMaxDeadband == 0.5);
  const auto within = [](double percent) {
    return percent >= 0.0 && percent <= kPercent * kMaxDeadband;
  };
  require_session(within(values.traffic.position_deadband_percent),
                  "position_deadband of --traffic must be from 0 to 50 %");
  require_session(within(values.traffic.force_deadband_percent),
                  "force_deadband of --traffic must be from 0 to 50 %");
  parameters.position_deadband = values.traffic.position_deadband_percent / kPercent;
  parameters.force_deadband = values.traffic.force_deadband_percent / kPercent;
  parameters.predictor = predictor(values.traffic.predictor);
  const std::optional<double> rate = packet_rate(values, role);
  if (!rate) return;
  require_session(*rate > 0.0 && *rate <= values.rate,
                  "packet_rate of --traffic must be above 0 Hz and at most --rate");
  // Round the interval up, so that the datagram rate is at most `rate`. Allow for a rounded `rate`:
  // 1000 Hz / 333.3 Hz counts as 3 ticks.
  constexpr double kRounded = 1e-3;
  const double ticks = std::ceil(values.rate / *rate - kRounded);
  require_session(ticks <= kMaxPacketInterval,
                  "packet_rate of --traffic must be at least --rate / 1000");
  parameters.packet_interval = std::max(1, static_cast<int>(ticks));
}

Renamed renamed_session_options(const CLI::App& mode, const CLI::App& traffic) {
  Renamed renamed = {{"bounding", "--mode METHOD,side=..."},
                     {"no-account", "--mode METHOD,account=off"},
                     {"profile", "--traffic PROFILE"},
                     {"no-local-model", "--local-model off"},
                     {"whole-surfaces", "--local-model whole"},
                     {"no-whole-surfaces", "--local-model patches"},
                     {"local-model=true", "--local-model whole"},
                     {"local-model=false", "--local-model off"}};
  append_renamed(renamed, mode, "--mode METHOD,");
  append_renamed(renamed, traffic, "--traffic ");
  return renamed;
}

}  // namespace feltwire
