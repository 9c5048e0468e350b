#pragma once

namespace feltwire {

/// [J] Energy since the first reading, at the true ends of a simulated device: of the true force
/// and movement, not of the written force and what the encoder shows.
struct TrueEnergy {
  double given = 0.0;    // by the motors, to what they move
  double burned = 0.0;   // by the viscous and dry friction of the motors
  double made = 0.0;     // the most by which `given` was above `burned`, at any time
  double to_hand = 0.0;  // by the handle, to the hand that holds it; translation only
};

}  // namespace feltwire
