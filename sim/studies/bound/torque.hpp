#pragma once
// Torque in closed loop: the torque that each law shows, its calmness, and the energy of the port
// of six degrees of freedom. docs/lab/torque.md is its page.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/hands/eight_hands.hpp"
#include "sim/studies/bound/torque_tasks.hpp"

namespace feltwire {

struct TorqueCase {
  std::string task = "cone";
  std::string law = "none";  // of the registry
  bool account = false;      // behind it
  Ports ports = Ports::one;  // of the account
  double damping = 8e-4;     // b_r [N m s/rad]
  double stiffness = 8.0;    // [N m/rad] of a joint's stop; bodies have their own
  double delay = 0.0;        // [s] a round trip
  NamedHand hand = kEightHands[0];
  /// The device's; the numbers of its hand are not used. Null: it is ideal. The torque passes its
  /// amplifier; rotation has no transmission.
  std::shared_ptr<const Plant> plant = nullptr;
  MotorLag told{};  // of the motor, as the law and the account are told
};

struct TorqueRow {
  TorqueCase made;
  double oscillation = 0.0;      // [rad] highpass_rms() of the true turn, worst axis
  double force_share = 0.0;      // rendered along commanded, of the commanded, 2nd half
  double torque_share = 0.0;     // the same for torque
  double direction_error = 0.0;  // [rad] mean, rendered against commanded torque
  SixDofEnergy energy;           // [J] with a plant, `real` is that of the true motor
  std::uint64_t excess = 0;      // samples in debt
};

/// The device of the study: `simulated_6dof` with this rotational damping.
DeviceSpec torque_device(double damping);
SixDofSetup torque_setup(const TorqueCase& made, const TorqueTask& task);

/// Joints by law, stiffness and delay; bodies by law and delay; all by eight hands.
std::vector<TorqueCase> torque_cases();
/// torque_cases() without delay, on a device with this plant. `told`: the laws and the accounts
/// know the lag of its amplifier.
std::vector<TorqueCase> torque_cases(const Plant& plant, bool told);
/// Runs every case, deterministic; rows in the order of the cases. Throws std::invalid_argument for
/// a task that is not there.
std::vector<TorqueRow> run_torque(const std::vector<TorqueCase>& cases);

/// A whole session of a tool with a body, in virtual time.
struct TorqueSession {
  std::string task, mode, link;
  NamedHand hand = kEightHands[0];
  bool local_model = false;  // replies bring the model of the body
  bool whole = false;        // and the client has body and solids in full; false: planes
  double duration = 3.0;     // [s]
  // Results.
  double energy_made = 0.0;                  // [J] at the encoders, beyond what was burned
  double energy_made_true = 0.0;             // [J] over the true movement, dry friction counted
  std::uint64_t violations = 0;              // samples
  double torque_rms = 0.0, ideal_rms = 0.0;  // [N m] on the hand, and of the scene there
  double torque_error = 0.0;                 // [N m] RMS of their difference
  double usual_error = 0.0;                  // [N m] median over time of its size
  double oscillation = 0.0;                  // [rad] as above
  double largest_jump = 0.0;  // [N m] a sample, of the torque on the hand beyond the ideal
};
/// By task, method, link and what the client has; also those without a bound, beside the scene.
std::vector<TorqueSession> torque_sessions();
void run_sessions(std::vector<TorqueSession>& sessions);

/// Writes torque.csv, torque.json and torque_sessions.csv to `directory` (created). Throws
/// std::runtime_error when something cannot be written.
void write_torque(const std::filesystem::path& directory, const std::vector<TorqueRow>& rows,
                  const std::vector<TorqueSession>& sessions);
std::string torque_table(const std::vector<TorqueRow>& rows);
std::string torque_sessions_table(const std::vector<TorqueSession>& sessions);

/// Whether no bounded port made energy: no session, and no case that has an account or a law that
/// is passive by itself. With a plant the energy of the true motor is judged, of the cases with an
/// account that is told the lag.
bool ports_hold(const std::vector<TorqueRow>& rows, const std::vector<TorqueSession>& sessions);

}  // namespace feltwire
