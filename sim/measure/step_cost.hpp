#pragma once

#include <vector>

#include "sim/measure/experiment.hpp"

namespace feltwire {

/// [ns] of CPU for one step of the setup's bound, together with its account if it has one: the
/// samples' displacements and commands are replayed through both. It is the mean over the samples
/// of the fastest of some replays, so that other work on the machine counts little. Precondition:
/// at least one sample; call it while no other thread of the program works.
double step_cost(const std::vector<ExperimentSample>& samples, const ExperimentSetup& setup);

}  // namespace feltwire
