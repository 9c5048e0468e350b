#include "sim/studies/bound/over_hands.hpp"

#include <algorithm>

#include "sim/measure/experiment_metrics.hpp"

namespace feltwire {
namespace {

/// Returns true if the oscillation is measured in a task. In the other tasks, the intended path
/// itself changes the distance to the surface.
bool is_flat(const std::string& task) {
  return task == "wall" || task == "press" || task == "tremor";
}

}  // namespace

OverHands over_hands(const std::vector<FrontierRow>& rows, const Picks& picks) {
  std::vector<double> shares, oscillations;
  OverHands result;
  for (const FrontierRow& row : rows) {
    if (!picks(row.made)) continue;
    const bool calm = !is_flat(row.made.task) || row.oscillation < kCalm;
    result.calm += calm ? 1 : 0;
    result.energy_made = std::max(result.energy_made, row.energy_made);
    result.made_at_motor = std::max(result.made_at_motor, row.energy.made);
    shares.push_back(calm ? row.displayed : 0.0);
    oscillations.push_back(row.oscillation);
  }
  result.hands = shares.size();
  if (shares.empty()) return result;
  result.median = median(shares);
  result.worst = std::ranges::min(shares);
  result.median_oscillation = median(oscillations);
  result.worst_oscillation = std::ranges::max(oscillations);
  return result;
}

}  // namespace feltwire
