#pragma once
// Compares the places of the bound (server, client or both) over delay, jitter and loss.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/hands/eight_hands.hpp"

namespace feltwire {

/// The losses of datagrams, in each direction.
struct SidesLoss {
  double loss = 0.0;   // share
  double burst = 0.0;  // [datagrams] mean run of losses; 0: independent
};

/// The measured cells. Every list must have an entry.
struct WhereToBoundGrid {
  std::vector<double> round_trips = {0.0, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3, 100e-3, 200e-3};  // [s]
  std::vector<double> jitters = {0.0, 1e-3, 5e-3, 20e-3};  // [s] of each direction
  std::vector<SidesLoss> losses = {{0.0, 0.0},  {0.01, 0.0}, {0.1, 0.0}, {0.3, 0.0},
                                   {0.01, 8.0}, {0.1, 8.0},  {0.3, 8.0}};
  std::vector<NamedHand> hands = {kEightHands[0]};
  bool adversarial_hand = true;  // with the task of the hand that takes energy
  /// The assumed damping over the device's damping: above 1 the bounds are wrong, and the taking
  /// hand must gain energy.
  double assumed_damping = 1.0;
  Plant plant = {};   // of the device; ideal by default
  bool told = false;  // the bounds and accounts use the lag of the plant's amplifier
};

/// All eight hands over all round trips, without loss and with 10 %, without jitter.
WhereToBoundGrid hands_where_to_bound_grid();

/// The compared bounds: none, and the choices of the session parameter.
inline constexpr std::string_view kSidesBounds[] = {"none", "server", "client", "both"};

/// A task under a bound over a link. The numbers are those of the second half of the run, except
/// for the energies.
struct WhereToBoundCell {
  std::string_view task, bound, hand;
  double round_trip = 0.0, jitter = 0.0;  // [s]
  SidesLoss loss;
  /// [m] RMS of the true height over the surface less a centred moving average of 51 ms.
  double oscillation = 0.0;
  /// [m] RMS of the same about its mean: with the slow oscillations that a delay makes. 0 for hands
  /// that intend to go in and out.
  double sway = 0.0;
  /// [N/m] least squares of the held normal force over the true depth, through zero.
  double displayed = 0.0;
  /// [rad] between the held force and the scene's force at the true position and velocity.
  double direction_mean = 0.0, direction_p99 = 0.0;
  double force_ratio = 0.0;  // sum of the held forces over that of the scene's
  double force_error = 0.0;  // RMS of their difference over RMS of the scene's
  /// [J] least value of burned energy less delivered energy, with the movement as the encoders
  /// measured it, with the true movement, and with the true movement and the device's Coulomb
  /// friction. With a plant that is not ideal the last one is minus the energy that the true motor
  /// made.
  double margin = 0.0, true_margin = 0.0, device_margin = 0.0;
  std::uint64_t violations = 0;  // samples after which more was given than burned, as measured
  double answered = 0.0;         // share of the samples
};
/// Whether its line has neither jitter nor loss.
inline bool clean(const WhereToBoundCell& cell) {
  return cell.jitter == 0.0 && cell.loss.loss == 0.0;
}

/// Every cell: tasks, bounds, round trips, jitters, losses, hands, the last fastest. 1 kHz, b = 0.5
/// N s/m, contact_frame, redundancy 3; the same fate for the same datagrams under all bounds.
/// Deterministic. Throws std::invalid_argument for a grid that cannot be run.
std::vector<WhereToBoundCell> run_where_to_bound(const WhereToBoundGrid& grid);

/// [J] that rounding may explain: a bound holds if no more is missing.
inline constexpr double kWhereToBoundRounding = 1e-9;

/// Whether no bounded port ever delivered more than the device burned: as measured, and over the
/// true movement with all of the device's dissipation.
bool bounds_hold(const std::vector<WhereToBoundCell>& cells);

/// Writes sides.csv, sides.json and sides.png, the same bytes every time. `directory` is created.
/// Throws std::runtime_error if something cannot be written or drawn.
void write_where_to_bound(const std::filesystem::path& directory,
                          const std::vector<WhereToBoundCell>& cells);

/// Writes sides_hands.csv to `directory`, which exists.
void write_where_to_bound_hands(const std::filesystem::path& directory,
                                const std::vector<WhereToBoundCell>& cells);
/// Cells of all eight hands over a clean line as tables for people: the median of the hands and the
/// worst.
std::string where_to_bound_hands_table(const std::vector<WhereToBoundCell>& cells);

/// By round trip over a clean line, and the worst and mean over all jitters and losses; for people.
std::string where_to_bound_table(const std::vector<WhereToBoundCell>& cells);

}  // namespace feltwire
