#pragma once
// The values of the command line, and the options that they set.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "client/app/client_options.hpp"
#include "client/command_line/credential_options.hpp"

namespace feltwire {

/// The values of the command line, before they are interpreted.
struct OptionValues {
  bool has_server = true;
  std::string config;  // file with options
  std::string connect, scene, device = "simulated", spec;
  std::string mode, projection = std::string(name(SessionParameters{}.projection)),
                    storage = "minimal", reference = "zero", side, account = "on", path = "press",
                    wrist = "still", predictor = "level";
  double wrist_angle = WristTask{}.angle;  // [rad]
  std::optional<std::vector<double>> damping;
  std::optional<double> mass;
  std::string local_model;  // off, patches or whole; empty: as the method and the profile need it
  bool rehearses = true;
  std::string changes = "none";
  double rate = 1000.0;
  std::optional<double> hold_time;    // [s]
  std::optional<double> packet_rate;  // [Hz]
  double position_deadband_percent = 0.0, force_deadband_percent = 0.0;
  std::optional<std::array<double, 3>> center, normal;
  std::optional<double> lead, press;           // [s]
  std::optional<std::array<double, 2>> trust;  // [J], [W] of the robot that it leads
  double map_scale = 1.0;
  std::optional<std::array<double, 3>> map_rotate, map_translate;  // [deg], [m]
  std::string map_mirror;
  std::string firmware;
  std::string plant;        // file of the simulated device
  std::string tool_weight;  // with its unit
  int emergency_button = 0;
  std::optional<int> deadman_button, clutch_button;
  std::optional<double> await_still;                      // [s]
  std::optional<double> let_go_after, longest_hold_time;  // [s]
  std::optional<double> wait_for_small_force, ramp_up, velocity_limit;
  std::string report, record, view, flight_recorder, link, traffic, dscp = "cs0", role = "operator";
  std::string profile;  // of the traffic
  RecordingLimits record_limits;
  CredentialOptions credentials;
};

/// Checks the values and sets the options. `task`: of the simulated hand. Throws
/// std::invalid_argument with the option's name.
void to_client_options(const OptionValues& values, HandTask task, ClientOptions& options);

}  // namespace feltwire
