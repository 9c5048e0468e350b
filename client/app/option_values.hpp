#pragma once
// The values of the command line, and the options that they set.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "client/app/client_options.hpp"
#include "client/command_line/credential_options.hpp"

namespace feltwire {

/// The task of the simulated hand.
struct HandValues {
  std::string path = "press", wrist = "still";
  double wrist_angle = WristTask{}.angle;               // [rad]
  std::optional<std::array<double, 3>> center, normal;  // [m]
  std::optional<double> press;                          // [s] time of a button press
  std::string plant;                                    // file
};

/// The workspace of the device in the scene.
struct MapValues {
  double scale = 1.0;
  std::optional<std::array<double, 3>> rotate, translate;  // [deg], [m]
  std::string mirror;
};

/// Numbers of the device's buttons, from 1.
struct ButtonValues {
  int emergency = 0;
  std::optional<int> deadman, clutch;
};

/// --device and --spec.
struct DeviceValues {
  std::string kind = "simulated", spec;
  std::optional<std::vector<double>> damping;
  std::optional<double> mass;
  std::string firmware;
  std::string tool_weight;            // with its unit
  std::optional<double> await_still;  // [s]
  HandValues hand;
  MapValues map;
  ButtonValues buttons;
};

/// --mode and its settings.
struct ModeValues {
  std::string method, projection = std::string(name(SessionParameters{}.projection)),
                      storage = "minimal", reference = "zero", side;
};

/// --traffic and its settings.
struct TrafficValues {
  std::string words, profile, predictor = "level";
  std::optional<double> packet_rate;  // [Hz]
  double position_deadband_percent = 0.0, force_deadband_percent = 0.0;
};

/// How long and how fast a force may act.
struct LimitValues {
  std::optional<double> hold_time, let_go_after, longest_hold_time;  // [s]
  std::optional<double> wait_for_small_force, ramp_up, velocity_limit;
};

struct FileValues {
  std::string report, record, view, flight_recorder;
  RecordingLimits record_limits;
};

/// The values of the command line, before they are interpreted.
struct OptionValues {
  bool has_server = true;
  std::string config;  // file with options
  std::string connect, scene, account = "on";
  DeviceValues device;
  ModeValues mode;
  TrafficValues traffic;
  std::string local_model;  // off, patches or whole; empty: as the method and the profile need it
  bool rehearses = true;
  std::string changes = "none";
  double rate = 1000.0;
  std::optional<double> lead;                  // [s]
  std::optional<std::array<double, 2>> trust;  // [J], [W] of the robot that it leads
  LimitValues limits;
  FileValues files;
  std::string link, dscp = "cs0", role = "operator";
  CredentialOptions credentials;
};

/// Checks the values and sets the options. `task`: of the simulated hand. Throws
/// std::invalid_argument with the option's name.
void to_client_options(const OptionValues& values, HandTask task, ClientOptions& options);

}  // namespace feltwire
