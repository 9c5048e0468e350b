#pragma once
// The sweeps of identify, and the place of the handle on each.

#include <vector>

#include "client/identify/swept.hpp"

namespace feltwire {

/// Five speeds up to `top_speed` [m/s], each along every axis and along the diagonals of every pair
/// of axes: the diagonals tell how axes are coupled. `dof`: 2 (x, y) or 3.
std::vector<Sweep> sweep_plan(int dof, double top_speed);

/// [s] of one cycle, there and back over 2 `amplitude` [m] each way.
double cycle_time(const Sweep& sweep, double amplitude);

/// [m] along the sweep from its centre, `time` [s] after a turn at -amplitude; begins at rest.
double led_to(const Sweep& sweep, double amplitude, double time);

}  // namespace feltwire
