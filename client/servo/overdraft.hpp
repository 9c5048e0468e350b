#pragma once
// A debt of the energy account that ends the force.

namespace feltwire {

/// [J] A tick that is microseconds late makes a smaller debt. A larger one is a fault: the hand got
/// energy that nothing had paid for, so the servo gives it no force any more.
inline constexpr double kLargestDebt = 3e-6;

struct Overdraft {
  double debt = 0.0;         // [J] the largest so far
  double hold_time = 0.0;    // [s] for which the force of the tick was held that made it
  bool strong_hand = false;  // a force from outside, or a speed, above the specified one made it
};

}  // namespace feltwire
