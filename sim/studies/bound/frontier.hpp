#pragma once
// The wall stiffness that each law shows on real devices, by the assumptions about the hand: the
// frontier between stiffness and guarantee.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/bounding/device_account.hpp"
#include "sim/hands/eight_hands.hpp"
#include "sim/studies/bound/compare_tasks.hpp"

namespace feltwire {

/// The account's knowledge of the port, in addition to the device's damping
/// (core/bounding/account.hpp).
enum class Need {
  no_account,        // the law alone
  unknown_hand,      // nothing: any hand
  inertia,           // the handle's mass and a hand of at most kHandForce
  inertia_friction,  // and three quarters of the device's dry friction
};
inline constexpr std::array<std::string_view, 4> kNeedNames = {"none", "unknown_hand", "inertia",
                                                               "inertia_friction"};
inline constexpr double kHandForce = 10.0;  // F_h [N]

struct FrontierDevice {
  std::string_view name;
  double mass, friction, quantum, max_force;  // [kg], [N], [m], [N]
};
/// The simulated device of the other studies, and a cable-driven one with the figures usually
/// quoted of a PHANToM Premium 1.5.
inline constexpr std::array<FrontierDevice, 2> kFrontierDevices = {
    {{"simulated", 0.05, 0.1, 23e-6, 8.9}, {"cable_driven", 0.075, 0.04, 30e-6, 8.5}}};

struct FrontierCase {
  std::string task = "wall";
  std::string law = "none";  // of the registry or of other papers
  Need need = Need::no_account;
  double damping = 0.5;  // b [N s/m]
  FrontierDevice device = kFrontierDevices[0];
  double wall = 4e4;   // [N/m]
  double delay = 0.0;  // [s] a round trip
  NamedHand hand = kEightHands[0];
  bool cold = true;          // else the hand moves 2 s in the air first, which fills the account
  double cap = kAccountCap;  // of the account, in needs of the device's largest force at rest
  double hand_force = kHandForce;  // F_h [N] that the account is told
  bool learns = false;             // the account learns it (core/bounding/hand_force_bound.hpp)
  double duration = 0.0;           // [s] 0: that of the task
  bool session = false;            // a whole session over a network, whose client has a local model
  /// The device's; the mass, damping and stiffness of its hand are not used. Null: it is ideal.
  std::shared_ptr<const Plant> plant = nullptr;
  MotorLag told{};  // of the motor, as the law and the account are told
};

struct FrontierRow {
  FrontierCase made;
  double oscillation = 0.0;  // [m] highpass_rms() of the true distance to the surface
  double displayed = 0.0;    // share of the surface's own force that is rendered, second half
  double displayed_at_encoder = 0.0;  // the same against the force at the motor's position; 0 of a
                                      // session
  double direction_error = 0.0;       // [rad] mean, rendered against commanded
  double energy_made = 0.0;  // [J] delivered beyond the burned energy, as the encoder shows it
  TrueEnergy energy{};       // at the true motor and at the true handle
  std::uint64_t excess = 0;  // samples in debt
};

/// The cases of the whole study.
std::vector<FrontierCase> frontier_cases();
/// Whole sessions of the law `shaped` with a local model, in process and over slow networks: the
/// paper's wall and sphere, taps, and a mesh of 3674 triangles.
std::vector<FrontierCase> session_cases();
/// The cases for the laws of other papers: the paper's wall, taps, the sphere, and a press on a
/// wall with a late command.
std::vector<FrontierCase> published_cases();

/// First presses and taps without delay, of every law, on devices with this plant. `shaped` runs as
/// a whole session with a local model, as in the client (frontier_plant.cpp).
/// `told`: the laws and the accounts are told the lag of the plant's amplifier.
std::vector<FrontierCase> plant_cases(const Plant& plant, bool told = false);

/// Whether the task of a case is on the wall of paper_wall.json, which any hand can touch.
bool on_wall(const std::string& task);

/// Runs every case, deterministic; rows in the order of the cases.
std::vector<FrontierRow> run_frontier(const std::vector<FrontierCase>& cases);

/// Runs and writes frontier.json, frontier.csv and pictures to `directory` (created). Throws
/// std::runtime_error when something cannot be written or drawn.
std::vector<FrontierRow> write_frontier(const std::filesystem::path& directory,
                                        const std::vector<FrontierCase>& cases);

/// Writes frontier.json and frontier.csv of these rows to `directory` (created). Throws
/// std::runtime_error.
void write_rows(const std::filesystem::path& directory, const std::vector<FrontierRow>& rows);

/// The energy that a wrong command gives to a hand, and the share that a right one shows, by the
/// cap of the account.
struct CapRow {
  double cap = 0.0;     // in needs of the device's largest force at rest
  double energy = 0.0;  // [J] the cap
  double given =
      0.0;  // [J] by a command that always pushes in the direction of the hand's movement
  double speed = 0.0;             // [m/s] speed that the hand reaches by it
  double wall = 0.0, taps = 0.0;  // displayed share, usual hand, warm
};
std::vector<CapRow> cap_trade();

/// The gain if the account learns the hand's force instead of assuming 10 N, compared with an
/// account that is told half of it: a minute of presses, slides and taps (frontier_learning.cpp).
std::vector<FrontierCase> learning_cases();
std::string learning_table(const std::vector<FrontierRow>& rows);

/// For people: the displayed share and how many hands are calm, by law, damping and delay; then the
/// results of the laws of other papers for the same cases, beside ours.
std::string frontier_table(const std::vector<FrontierRow>& rows);
std::string sessions_table(const std::vector<FrontierRow>& rows);
/// For plant_cases(), by device, damping and wall, and every law: the median share that is shown at
/// the handle, how many hands are calm there, the most energy that the true motor made.
std::string plant_table(const std::vector<FrontierRow>& rows);
std::string published_table(const std::vector<FrontierRow>& rows);

}  // namespace feltwire
