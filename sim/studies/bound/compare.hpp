#pragma once
// Every method on the same surfaces, side by side.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/hands/eight_hands.hpp"
#include "sim/measure/methods.hpp"
#include "sim/measure/step_cost.hpp"
#include "sim/studies/bound/compare_tasks.hpp"

namespace feltwire {

/// The loop that all methods run in.
struct CompareLoop {
  double damping = 0.5;  // b [N s/m] of the device, >= 0
  double rate = 1000.0;  // [Hz], > 0
  double delay = 0.0;    // [s] a round trip, >= 0; rounded up to whole samples
  Hand hand = kEightHands[0].hand;
};

struct CompareRow {
  std::string task, method;
  double oscillation = 0.0;  // [m] RMS over the second half of the true distance to the surface,
                             // less a centred moving average of 51 ms
  double direction_error = 0.0;  // [rad] mean angle between rendered and commanded force
  double displayed = 0.0;    // stiffness displayed over commanded: least squares of the rendered
                             // force over the surface's own elastic one, at the true position
                             // and without delay
  double energy_made = 0.0;  // [J] largest energy delivered to the hand beyond the energy that the
                             // device burned; 0 is passive
  double cost = 0.0;         // [ns] a step of the bound: mean over the same run, replayed alone
};

/// The row with the effect of the surface itself on the numbers: no bound, 20 kHz, no encoder
/// quantum, no delay.
inline constexpr const char* kReference = "reference";

/// The type of step_cost().
using StepCost =
    std::function<double(const std::vector<ExperimentSample>&, const ExperimentSetup&)>;

/// Every task by every method, after the task's reference. All but `cost` is deterministic. The
/// runs share the machine's cores; then `step_cost` measures them one after the other, while no
/// other thread works. Throws std::invalid_argument for a loop that cannot be run.
std::vector<CompareRow> compare(const std::vector<CompareTask>& tasks,
                                const std::vector<Method>& methods, const CompareLoop& loop,
                                const StepCost& step_cost = feltwire::step_cost);

/// A task with a method, over all eight hands on the same path: a soft arm presses less.
struct CompareHandsRow {
  std::string task, method;
  double oscillation = 0.0, worst_oscillation = 0.0;  // [m] median of the hands, largest
  double displayed = 0.0, least_displayed = 0.0;      // median, least
  double energy_made = 0.0;                           // [J] the most
};
/// Every task by every method, without a reference. Deterministic. Throws as compare(); `loop.hand`
/// is not read.
std::vector<CompareHandsRow> compare_hands(const std::vector<CompareTask>& tasks,
                                           const std::vector<Method>& methods,
                                           const CompareLoop& loop);

/// Compares these methods on these tasks and writes compare.json, compare.csv and compare_cost.csv
/// to `directory` (created). Throws std::runtime_error when something cannot be written.
std::vector<CompareRow> write_compare(const std::filesystem::path& directory,
                                      const CompareLoop& loop,
                                      const std::vector<CompareTask>& tasks,
                                      const std::vector<Method>& methods);

/// Compares everything and writes compare.json, compare.csv, compare.png, compare_hands.csv
/// and, as it is never the same twice, compare_cost.csv apart, to `directory` (created). Throws
/// std::runtime_error when something cannot be written or drawn.
struct Comparison {
  std::vector<CompareRow> rows;        // by loop.hand
  std::vector<CompareHandsRow> hands;  // by all eight
};
Comparison write_compare(const std::filesystem::path& directory, const CompareLoop& loop);

/// The rows as tables for people.
std::string compare_table(const std::vector<CompareRow>& rows);
std::string compare_hands_table(const std::vector<CompareHandsRow>& rows);

}  // namespace feltwire
