#pragma once
// The settings of a session, which a client requests and a server grants.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/bounding/bounding.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The sides that run the energy bound.
enum class BoundingSide : std::uint8_t { server, client, both };
inline constexpr std::array<std::string_view, 3> kBoundingSideNames = {"server", "client", "both"};
/// The value with which a deadband compares a new one: the value sent last, or the line through the
/// values sent last.
enum class Predictor : std::uint8_t { level, linear };
inline constexpr std::array<std::string_view, 2> kPredictorNames = {"level", "linear"};

inline constexpr double kShortestServoPeriod = 1e-5, kLongestServoPeriod = 0.1;  // [s]
inline constexpr int kMaxRedundancy = 8;         // k: earlier samples repeated
inline constexpr int kMaxPacketInterval = 1000;  // [servo ticks]
inline constexpr double kMaxDeadband = 0.5;      // Weber fraction
inline constexpr double kStiffest = 1e9;         // [N/m]

/// The settings of a session. A client requests them, the server grants them. All except
/// servo_period can be changed while the session runs.
struct SessionParameters {
  std::string mode{kDefaultMethod};          // a method of the registry, core/bounding/method.hpp
  Projection projection = Projection::cone;  // measured: docs/bounding.md, "joint or cone"
  Storage storage = Storage::minimal;        // measured: the same page, "minimal or elastic"
  BoundingSide side = BoundingSide::client;  // measured: docs/network.md, "Who bounds"
  double servo_period = 1e-3;                // T [s], 1e-5 to 0.1
  int redundancy = 3;                        // k, 0 to kMaxRedundancy
  double operator_damping = 0.0;  // [N s/m] damping of the operator's hand that the bound assumes,
                                  // 0 to 100; the account does not
  double velocity_cutoff = 0.0;   // [Hz] of the server's velocity estimate, 0: none
  double hold_time =
      0.1;  // [s] from half of this age on a command fades, at this age it is zero; T to 1
  std::optional<double> c1, c2;                             // [N/m] the paper's modes; default b/T
  PassivityReference reference = PassivityReference::zero;  // passivity_control*
  // virtual_coupling: [N/m] and [N s/m], by default the stiffest that is passive; [kg] of the tool
  std::optional<double> coupling_stiffness, coupling_damping;
  double tool_mass = 0.05;
  // The traffic. n T is at most hold_time, m + k at most kMaxRedundancy + 1.
  int packet_interval = 1;  // n [servo ticks] from one datagram to the next, 1 to 1000
  int batch = 1;            // m: samples of these n that are sent, evenly spaced, 1 to n
  double position_deadband =
      0.0;                      // Weber fraction: a smaller change is not sent; 0 to 0.5; 0: always
  double force_deadband = 0.0;  // the same for replies
  Predictor predictor = Predictor::level;
  double keep_alive = 0.02;  // [s] longest silence of either deadband, 0 to 1; with one n T to
                             // hold_time / 2, with both n T to hold_time / 4
  bool local_model = false;  // replies bring the surfaces near the tool; the client renders them

  friend bool operator==(const SessionParameters&, const SessionParameters&) = default;
};

std::string_view name(BoundingSide side);
/// Throws std::invalid_argument that lists the choices if there is no such side.
BoundingSide bounding_side(std::string_view name);
std::string_view name(Predictor predictor);
/// Throws std::invalid_argument that lists the choices if there is no such predictor.
Predictor predictor(std::string_view name);

/// Throws std::invalid_argument that names the field, the range and the remedy; for a mode that is
/// not in the registry, the choices. A method that stands beside the scene runs on the server only,
/// one that shapes on the client only.
void validate(const SessionParameters& parameters);

/// The parameters that a hand requests by default: kSessionMethod, and a local model of the
/// surfaces near its tool, so that their force has no delay.
SessionParameters usual_parameters();

/// The configuration of the bound for a session of this device, on either side.
BoundingConfig bounding_config(const SessionParameters& parameters, const DeviceSpec& device);

}  // namespace feltwire
