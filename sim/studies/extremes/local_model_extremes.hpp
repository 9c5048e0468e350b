#pragma once
// Local models of every shape at extreme sizes, places and materials, through the wire.

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

/// Presses a tool into scenes of one object, sends the local model as the server does, and compares
/// the client's force from it with the scene's force, at the model's centre and beside it.
/// Deterministic.
ExtremeMatrix run_local_model_extremes(double assumed_scale = 1.0);

}  // namespace feltwire
