#pragma once
// The contact of a point and of a ball with every shape, a mesh and a grid, at extreme sizes,
// places, proportions and materials.

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

/// Presses tools into scenes of one object and compares the force with a closed form in long
/// double, at the place that the tool really has after rounding. Deterministic.
ExtremeMatrix run_contact_extremes(double assumed_scale = 1.0);

}  // namespace feltwire
