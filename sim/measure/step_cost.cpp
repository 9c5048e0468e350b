#include "sim/measure/step_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/measure/cost.hpp"

namespace feltwire {

double step_cost(const std::vector<ExperimentSample>& samples, const ExperimentSetup& setup) {
  constexpr int kReplays = 5;
  double best = std::numeric_limits<double>::infinity();
  for (int replay = 0; replay < kReplays; ++replay) {
    Bounding bounding = bounding_of(setup);
    std::optional<PortAccount> account;
    if (setup.account) account.emplace(*setup.account);
    double sum = 0.0;
    const double begin = cpu_seconds();
    for (const ExperimentSample& s : samples) {
      BoundingStep step{.displacement = s.displacement,
                        .rotation = Vec3::Zero(),
                        .hold_time = setup.bounding.period,
                        .command = s.commanded,
                        .local = setup.delay == 0};
      step.command = bounding.step(step).rendered;
      if (account) step.command = account->step(step);
      bounding.set_held(step.command);
      sum += step.command.elastic.sum();
    }
    const double time = cpu_seconds() - begin;
    // Use the sum, so that the compiler does not remove the steps.
    if (std::isfinite(sum)) best = std::min(best, time);
  }
  return 1e9 * best / static_cast<double>(samples.size());
}

}  // namespace feltwire
