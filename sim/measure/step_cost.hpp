#pragma once

#include <vector>

#include "sim/measure/experiment.hpp"

namespace feltwire {

/// [ns] of CPU that one step of the setup's bound takes, together with its account where it has
/// one: the samples' displacements and commands are replayed through both. The mean over the
/// samples of the quickest of some replays, so that other work on the machine counts little.
/// Precondition: at least one sample; call it while no other thread of the program works.
double step_cost(const std::vector<ExperimentSample>& samples, const ExperimentSetup& setup);

}  // namespace feltwire
