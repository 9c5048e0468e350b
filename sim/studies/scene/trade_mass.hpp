#pragma once
// A tool with mass: without mass, by backward Euler, by the passive midpoint rule. Accuracy,
// stability, time.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// The measured masses and stiffnesses.
struct MassGrid {
  std::vector<double> masses = {1e-3, 1e-2, 0.1, 1.0, 10.0};         // [kg]
  std::vector<double> stiffnesses = {1e2, 1e3, 1e4, 1e5, 1e6, 1e7};  // [N/m] of the plane
  std::vector<double> periods = {2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3};    // [s]
  int finer = 100;          // the reference's steps in one of 1 ms
  double task_time = 1.0;   // [s] of the tasks
  double throw_time = 3.0;  // [s] that a thrown tool has to come to rest
  int cost_steps = 20'000;
};

/// Ways to move a tool: "none" (no mass), "implicit", "midpoint".
///
/// The force that a hand feels against that of steps so much finer, for a tool of this mass.
/// Tasks, each with a box of 60 x 40 x 20 mm on a critically damped coupling of 1 kN/m:
///   sway  to and fro in free space, 50 mm and 2 Hz
///   tap   three times a second 10 mm into a frictionless plane of 1 kN/m, from 10 mm above
struct MassAccuracy {
  std::string task, way;
  double mass = 0.0;         // [kg]
  double period = 0.0;       // [s]
  double force_error = 0.0;  // RMS over the RMS of the reference's force
};

/// A tool thrown at 0.5 m/s onto a plane without friction or damping, 5 degrees tilted; weight, and
/// the coupling of 1 kN/m to a device that stands at the surface, without damping: nothing but the
/// integration can calm it.
struct MassStability {
  std::string way;
  double stiffness = 0.0, mass = 0.0;  // [N/m], [kg]
  double most = 0.0;   // the largest energy at any time, over that at the beginning, above the rest
  double left = 0.0;   // the energy at the end, likewise
  double rests = 0.0;  // [s] until it moves slower than 1 mm/s for good; < 0: never
};

/// The time of a step on this machine, with 1000 points and a mass of 0.1 kg.
struct MassCost {
  std::string task, way;
  double median_ns = 0.0, p99_ns = 0.0;  // [ns] of wall time
  double evaluations = 0.0;              // of all contacts, mean (the same in every run)
};

struct MassTrade {
  std::vector<MassAccuracy> accuracy;
  std::vector<MassStability> stability;
  std::vector<MassCost> cost;
};

MassTrade run_trade_mass(const MassGrid& grid);

/// Writes trade_mass.csv, trade_mass_stability.csv and trade_mass.png, the same bytes every time,
/// and apart from them the times on this machine: trade_mass_cost.csv. `directory` is created.
/// Throws std::runtime_error if something cannot be written or drawn.
void write_trade_mass(const std::filesystem::path& directory, const MassTrade& trade);

/// All results for people.
std::string trade_mass_table(const MassTrade& trade);

}  // namespace feltwire
