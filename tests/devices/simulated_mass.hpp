#pragma once
// A stand-in's handle: a mass with damping and dry friction, in a hand that taps and slides. It is
// integrated in fine steps, with the energy of its true motion. It knows nothing of feltwire.

#include <algorithm>
#include <array>
#include <cmath>

namespace stand_in {

using Three = std::array<double, 3>;

struct SimulatedMass {
  double mass = 0.1, damping = 0.5, friction = 0.05;  // [kg], [N s/m], [N] an axis: the truth
  double quantum = 20e-6;                             // [m] of the encoder
  double stiffness = 200.0, hand_damping = 2.0;       // [N/m], [N s/m] of the hand
  double tool = 0.0;     // [N] weight of the tool at the handle, along -z
  double counter = 0.0;  // [N] constant part of the force along z; its work does not count
  double waits = 0.0;    // [s] for which the hand is still at the start
  double depth = 0.008, reach = 0.02;  // [m] of the taps into z < 0, and of the slide in x

  Three position{0, 0, 0.01}, velocity{};
  double time = 0.0;                     // [s]
  double delivered = 0.0, burned = 0.0;  // [J] by the force on the handle; by damping and friction
  double most_made = 0.0;                // [J] largest delivered less burned energy
  double largest_force = 0.0;            // [N] on the handle

  void advance(double span, const Three& force) {
    constexpr double kStep = 10e-6, kTurn = 6.283185307179586;
    const int steps = std::max(1, static_cast<int>(std::ceil(span / kStep)));
    const double h = span / steps;
    largest_force = std::max(largest_force, std::hypot(force[0], force[1], force[2]));
    for (int n = 0; n < steps; ++n) {
      time += h;
      const double moves = std::max(0.0, time - waits);
      const Three wanted{reach * std::sin(kTurn * 0.7 * moves), 0.0,
                         0.004 - (0.004 + depth) * std::sin(kTurn * 1.5 * moves)};
      for (std::size_t i = 0; i < 3; ++i) {
        const double pull = stiffness * (wanted[i] - position[i]) - hand_damping * velocity[i];
        const double down = i == 2 ? tool : 0.0;
        double v = (velocity[i] + h / mass * (pull - down + force[i])) / (1.0 + h / mass * damping);
        const double most = friction * h / mass;
        v = std::abs(v) > most ? v - std::copysign(most, v) : 0.0;
        velocity[i] = v;
        position[i] += h * v;
        delivered += (force[i] - (i == 2 ? counter : 0.0)) * v * h;
        burned += (damping * v * v + friction * std::abs(v)) * h;
      }
      most_made = std::max(most_made, delivered - burned);
    }
  }
  Three sensed() const {
    Three p = position;
    for (double& x : p) x = std::round(x / quantum) * quantum;
    return p;
  }
};

}  // namespace stand_in
