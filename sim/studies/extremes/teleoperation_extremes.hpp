#pragma once
// A robot that follows, and the two-port bound of the hand that leads it, with extreme targets,
// readings, stiffnesses, periods and counts.

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

/// Runs the follower's servo with a robot at a wall, and the two-port bound with a hand that takes
/// all it can. Deterministic.
ExtremeMatrix run_teleoperation_extremes(double assumed_scale = 1.0);

}  // namespace feltwire
