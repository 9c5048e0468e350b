#pragma once
// The stiffest wall that each method can show a hand, by device and by loop: a map for device
// builders.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/hands/eight_hands.hpp"
#include "sim/measure/methods.hpp"
#include "sim/measure/stiffness_search.hpp"

namespace feltwire {

/// The cells of the map. Every list must have an entry.
struct ZWidthGrid {
  std::vector<Method> methods;
  std::vector<double> dampings = {0.5, 2.0, 8.0};            // b [N s/m] of the device
  std::vector<double> rates = {500, 1000, 2000, 4000, 1e4};  // [Hz] of servo loop and wall
  std::vector<double> delays = {0.0, 1e-3, 5e-3, 20e-3};     // [s] a round trip
  std::vector<NamedHand> hands = {kEightHands[0]};
  StiffnessRange range;
  Plant plant = {};  // of the device; the mass, damping and stiffness of its hand are not used
};
/// All methods, everywhere, by one hand.
ZWidthGrid full_zwidth_grid();
/// All methods at 1 kHz, by all eight hands.
ZWidthGrid hands_zwidth_grid();

/// [N/m] The stiffness that every method gets in addition to its own largest.
inline constexpr double kFixedStiffness = 5000.0;
/// A movement of the hand by more than this [m], RMS, is an oscillation.
inline constexpr double kFeltOscillation = 10e-6;

/// A press: a hand comes in along the normal of a frictionless wall within 0.5 s (some 60 mm/s at
/// the surface) and rests there until 2 s. It presses with 3 N, or less if 3 N would take more than
/// 30 mm of wall. Both numbers are of the last second.
struct Press {
  double oscillation = 0.0;  // [m] RMS of the true position along the normal, less a centred moving
                             // average of 51 ms
  std::optional<double> displayed;  // [N/m] rendered normal force over true depth at rest; empty if
                                    // the hand oscillates, or does not touch
  bool calm() const { return oscillation <= kFeltOscillation; }
};
Press press_wall(const Method& method, double damping, double rate, double delay, double stiffness,
                 const Hand& hand = kEightHands[0].hand, const Plant& plant = {});

struct ZWidthCell {
  std::string_view method;
  std::string_view hand;
  double damping = 0.0, rate = 0.0, delay = 0.0;  // [N s/m], [Hz], [s]
  int samples = 0;                                // the delay in whole samples, rounded up
  StiffnessLimit limit;  // of presses that move the hand by kFeltOscillation or less
  Press at_limit;        // empty if no stiffness was calm
  Press at_fixed;        // kFixedStiffness
};

/// Every cell, hands fastest, then delays, rates, dampings, methods.
std::vector<ZWidthCell> map_zwidth(const ZWidthGrid& grid);

/// Above 2 f_c / quantum [N/m] one encoder step changes the wall's force by more than the device's
/// Coulomb friction can absorb, and the noise is felt under every method (Diolaiti et al. 2006).
double quantum_limit();

/// Maps and writes zwidth.json, zwidth.csv and a picture for each damping to `directory` (created).
/// Throws std::runtime_error if something cannot be written or drawn.
std::vector<ZWidthCell> write_zwidth(const std::filesystem::path& directory,
                                     const ZWidthGrid& grid);

/// Writes zwidth_hands.csv to `directory`, which exists.
void write_zwidth_hands(const std::filesystem::path& directory,
                        const std::vector<ZWidthCell>& cells);
/// Cells of all eight hands as a table for people: the median of the hands and the worst.
std::string zwidth_hands_table(const std::vector<ZWidthCell>& cells);

/// The map as tables for people: all rates at the grid's first delay, all delays at its second
/// rate.
std::string zwidth_table(const std::vector<ZWidthCell>& cells, const ZWidthGrid& grid);

}  // namespace feltwire
