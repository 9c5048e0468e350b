#pragma once
// Speed against accuracy: the effect of servo rate and arithmetic on a hand, and their cost.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/hands/eight_hands.hpp"

namespace feltwire {

/// The arithmetic of a loop. In float: the position that the device reports, rounded to float in a
/// world frame with its origin at the given distance; the displacement, the command and the whole
/// bound. Always in double: the scene's contact, and the simulated hand.
struct RateArithmetic {
  std::string_view name;
  bool in_float = false;
  double origin = 0.0;  // [m] distance of the touched place from the origin, along every axis
};
inline constexpr RateArithmetic kRateArithmetics[] = {
    {"double", false, 0.0}, {"float 0.1 m", true, 0.1}, {"float 1 m", true, 1.0}};

/// The measured cells. Every list must have an entry.
struct RateGrid {
  std::vector<double> rates = {250, 500, 1000, 2000, 4000, 1e4, 2e4};  // [Hz]
  std::vector<double> dampings = {0.5, 2.0};                           // b [N s/m]
  std::vector<NamedHand> hands = {kEightHands[0]};
  bool float_too = true;  // false: in double only
  Plant plant = {};       // of the device; ideal by default
  bool told = false;      // the bound uses the lag of the plant's amplifier
};
/// All rates and dampings in double, by all eight hands.
RateGrid hands_rate_grid();

struct RateCell {
  std::string surface;               // "wall 40 kN/m", "wall 1 kN/m", "sphere 5 kN/m"
  double damping = 0.0, rate = 0.0;  // [N s/m], [Hz]
  std::string_view arithmetic, hand;
  /// [N/m] least-squares slope of the rendered normal force over the true depth, while the depth
  /// of a hand that presses up to 3 N within a second grows.
  double displayed = 0.0;
  /// [rad] mean angle between the held force and the surface's force at the true position and
  /// velocity at that moment, over a slide (wall) or a turn (sphere).
  double direction_error = 0.0;
  /// [m] RMS of the true depth less a centred moving average of 51 ms, over the second half of it.
  double oscillation = 0.0;
};

/// Every cell: surfaces, dampings, rates, arithmetics, hands, the last fastest. contact_frame with
/// cone projection on the built-in simulated device. Deterministic.
std::vector<RateCell> run_rate(const RateGrid& grid);

/// CPU time of one step on this machine, on the inputs of the sliding runs at 1 kHz.
struct RateCost {
  std::string surface;
  double touch_ns = 0.0, bound_double_ns = 0.0, bound_float_ns = 0.0;
};
std::vector<RateCost> measure_rate_cost();

/// Writes rate.csv, rate.json and rate.png, the same bytes every time, and apart from them the
/// times on this machine: rate_cost.csv and rate_cost.png. `directory` is created. Throws
/// std::runtime_error if something cannot be written or drawn.
void write_rate(const std::filesystem::path& directory, const RateGrid& grid,
                const std::vector<RateCell>& cells, const std::vector<RateCost>& costs);

/// Writes rate_hands.csv to `directory`, which exists: a cell by each of the eight hands.
void write_rate_hands(const std::filesystem::path& directory, const std::vector<RateCell>& cells);
/// Cells of all eight hands as a table for people: the median of the hands and the worst.
std::string rate_hands_table(const std::vector<RateCell>& cells);

/// Both as tables for people.
std::string rate_table(const std::vector<RateCell>& cells);
std::string rate_cost_table(const RateGrid& grid, const std::vector<RateCost>& costs);

}  // namespace feltwire
