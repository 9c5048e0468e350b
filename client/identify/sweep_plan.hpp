#pragma once
// The sweeps of identify, and the place of the handle on each.

#include <vector>

#include "client/identify/sweep_record.hpp"

namespace feltwire {

/// The share of the time of one way, at each end, in which the speed rises or falls.
inline constexpr double kTurnShare = 0.2;

/// Five speeds up to `top_speed` [m/s], each along every axis and along the diagonals of every pair
/// of axes: the diagonals tell how axes are coupled. `dof`: 2 (x, y) or 3.
std::vector<Sweep> sweep_plan(int dof, double top_speed);

/// [Hz] The highest frequency of shaken_plan().
inline constexpr double kHighestLagShake = 40.0;

/// Sweeps at half of `top_speed` [m/s] along every axis, each shaken at one of five frequencies:
/// for the lag.
std::vector<Sweep> shaken_plan(int dof, double top_speed);

/// Sweeps of the same speed, each shaken at one of six higher frequencies: for the resonance of a
/// transmission.
std::vector<Sweep> resonance_plan(int dof, double top_speed);

/// [rad] of the shake in a cycle of a sweep, counted from 0 on: a quarter, a half and three
/// quarters of a period apart in any four cycles.
double shake_phase(int cycle);

/// The share of the shake's amplitude at the time `time` of a sweep: nothing at the turns.
double shake_share(const Sweep& sweep, double amplitude, double time);

/// [s] of one cycle, there and back over 2 `amplitude` [m] each way.
double cycle_time(const Sweep& sweep, double amplitude);

/// [m] along the sweep from its centre, `time` [s] after a turn at -amplitude; begins at rest.
double led_to(const Sweep& sweep, double amplitude, double time);

}  // namespace feltwire
