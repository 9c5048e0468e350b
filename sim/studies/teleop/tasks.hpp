#pragma once
// The tasks of the hand on the bench, and their measures.

#include <optional>
#include <string_view>
#include <vector>

#include "sim/studies/teleop/bench.hpp"

namespace feltwire::teleop {

/// The measures; empty if the task does not show them.
struct Measured {
  std::optional<double> displayed;    // force over the way into the surface, over series stiffness
  std::optional<double> oscillation;  // [m] high-passed RMS of the hand that presses
  std::optional<double> drag;         // [N] RMS in free space
  std::optional<double> tracking;     // [m] RMS of the robot less the target one way ago
  std::optional<double> force_error;  // [N] RMS against the series spring without delay
  std::optional<double> force_share;  // the same over the RMS of that spring's force
  std::optional<double> drift;        // [m] at rest, at the end
  std::optional<double> inserted;     // [m] the robot's tip below the rim of the hole, at the end
  std::optional<double> phantom;      // share of the time without contact with a force at the hand
  std::optional<double> release;      // [s] LostContact::release
  double energy_made = 0.0;           // [J] to the hand beyond burned and pushed
  double peak_force = 0.0;            // [N] on the environment
};

struct Window {
  double from = 0.0, until = 0.0;  // [s]
};

struct Task {
  enum class Judge : std::uint8_t { press, force, free, drift };
  std::string_view name;
  Judge judge = Judge::press;
  BenchSetup setup;
  Window window;  // of the measures
};

/// free, press_first, press_second, taps, moving_wall, leaving_wall, vanishing_wall, lift,
/// blackout, drift. Positions [m] from the wall on; the hand starts in the air.
const std::vector<Task>& tasks();

/// K_s [N/m] of the robot's controller and a surface of this stiffness [N/m] in series.
double series_stiffness(const Plant& plant, double surface);

/// Judges a run of a task over this round trip [s].
Measured judge(const Task& task, const std::vector<BenchSample>& samples, double round_trip);

}  // namespace feltwire::teleop
