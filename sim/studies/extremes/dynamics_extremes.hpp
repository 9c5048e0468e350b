#pragma once
// Moving bodies with extreme masses, mass ratios, sizes and ticks, at their stops and in a pile.

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

/// Simulates small scenes and compares them with closed forms: the fall, the stop of a joint, the
/// rest on a floor, the momentum of a collision, and the limit of a hand's force. Deterministic.
ExtremeMatrix run_dynamics_extremes(double assumed_scale = 1.0);

}  // namespace feltwire
