#pragma once
// The inputs of a bound at the extremes: the hands, and their commands.

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/bounding/bounding.hpp"
#include "sim/studies/bound/passivity_claims.hpp"

namespace feltwire {

class StressRandom {
 public:
  explicit StressRandom(std::uint64_t seed) : engine_(seed) {}
  double uniform(double lo, double hi) { return lo + (hi - lo) * unit(); }
  bool chance(double probability) { return unit() < probability; }
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(unit() * static_cast<double>(count));
  }
  /// Anywhere on the ball's surface, its size spread evenly over the decades 10^lo to 10^hi.
  Vec3 vector(double lo, double hi) {
    Vec3 v;
    do {
      for (double& x : v) x = uniform(-1.0, 1.0);
    } while (v.norm() < 0.1 || v.norm() > 1.0);
    return v.normalized() * std::pow(10.0, uniform(lo, hi));
  }

 private:
  // Not std::uniform_real_distribution: its bits differ between standard libraries.
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

/// The inputs of one row of hands.
struct StressInputs {
  std::string name;
  Damping damping = 0.5;                       // [N s/m]
  Damping rotational_damping = 2e-4;           // [N m s/rad]
  double period = 1e-3;                        // [s]
  double least_move = -9, largest_move = -1;   // decades [m], [rad]
  bool denormal_moves = false;                 // of the arithmetic, instead
  double still = 0.02;                         // probability of no movement at all
  double least_force = -3, largest_force = 3;  // decades [N]; torques two decades below
  double max_force = std::numeric_limits<double>::infinity();  // [N]; torques a hundredth
  double origin = 0.0;  // [m] where the hand is, on every axis: movements are differences there
  double longest_hold = 1.0;    // [T] every tenth sample lasts up to that
  double skipped_writes = 0.0;  // probability that the device goes on holding the force before
  double fades = 0.0;           // probability that it holds less than what was rendered
  double strange_inputs = 0.0;  // probability of NaN, Inf or out of range, each step in one input

  Faults faults() const {
    return {.overlong_holds = longest_hold > 1.0 || skipped_writes > 0.0,
            .reductions = fades > 0.0 || skipped_writes > 0.0 || std::isfinite(max_force),
            .unknown_inputs = strange_inputs > 0.0};
  }
};

/// Every stress, in the order of the table.
std::vector<StressInputs> all_stress_inputs();

struct StressedMovement {
  Vec3 displacement = Vec3::Zero(), rotation = Vec3::Zero();
};

/// A hand that knows its force. Five kinds: greedy, exactly and nearly so, pumping, taking from one
/// channel, restless, and one that changes its mind. `least` and `largest` are decades [m], [rad].
StressedMovement move(int kind, StressRandom& random, const StressInputs& stress,
                      const Command& held, double hold_time, double least, double largest);

/// Commands that a scene might give, and commands that no scene gives.
Command command(StressRandom& random, const StressInputs& stress);

}  // namespace feltwire
