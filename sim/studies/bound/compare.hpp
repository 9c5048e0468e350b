#pragma once
// Every method on the same things to touch, side by side.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/measure/methods.hpp"
#include "sim/measure/step_cost.hpp"
#include "sim/studies/bound/compare_tasks.hpp"

namespace feltwire {

/// The loop that all methods run in.
struct CompareLoop {
  double damping = 0.5;  // b [N s/m] of the device, >= 0
  double rate = 1000.0;  // [Hz], > 0
  double delay = 0.0;    // [s] a round trip, >= 0; rounded up to whole samples
};

struct CompareRow {
  std::string task, method;
  double oscillation = 0.0;  // [m] RMS over the second half of the true distance to the surface,
                             // less a centred moving average of 51 ms
  double direction_error = 0.0;  // [rad] mean angle between rendered and commanded force
  double displayed = 0.0;    // stiffness displayed over commanded: least squares of the rendered
                             // force over the surface's own elastic one, at the true position
                             // and without delay
  double energy_made = 0.0;  // [J] the most that was delivered to the hand beyond what the device
                             // burned; 0 is passive
  double cost = 0.0;         // [ns] a step of the bound: mean over the same run, replayed alone
};

/// The row that says what the surface itself does to the numbers: no bound, 20 kHz, no encoder
/// quantum, no delay.
inline constexpr const char* kReference = "reference";

/// As step_cost().
using StepCost =
    std::function<double(const std::vector<ExperimentSample>&, const ExperimentSetup&)>;

/// Every task by every method, after the task's reference. All but `cost` is deterministic. The
/// runs share the machine's cores; then `step_cost` measures them one after the other, while no
/// other thread works. Throws std::invalid_argument for a loop that cannot be run.
std::vector<CompareRow> compare(const std::vector<CompareTask>& tasks,
                                const std::vector<Method>& methods, const CompareLoop& loop,
                                const StepCost& step_cost = feltwire::step_cost);

/// Compares everything and writes compare.json, compare.csv, compare.png and, as it is never the
/// same twice, compare_cost.csv apart, to `directory` (created). Throws std::runtime_error when
/// something cannot be written or drawn.
std::vector<CompareRow> write_compare(const std::filesystem::path& directory,
                                      const CompareLoop& loop);

/// The rows as a table for people.
std::string compare_table(const std::vector<CompareRow>& rows);

}  // namespace feltwire
