#pragma once
// Datagrams with extreme places, forces, indices, times and rates, through the codec and a session.

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

/// Sends values through the codec and compares them with the values before. The allowed error is
/// half a step of the number type on the wire. Deterministic.
ExtremeMatrix run_wire_extremes(double assumed_scale = 1.0);

}  // namespace feltwire
