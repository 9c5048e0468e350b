#pragma once

#include "core/types.hpp"

namespace feltwire {

/// What one bounding step is told: how the device moved while the last force was held, and what is
/// wanted next.
struct BoundingStep {
  Vec3 displacement = Vec3::Zero();  // dx(n) = x(n) - x(n-1) [m]
  Vec3 rotation = Vec3::Zero();      // dtheta(n), rotation vector of q(n) q(n-1)^-1 [rad]
  double hold_time =
      0.0;          // [s] how long the last force was really held; shorter than T counts as T
  Command command;  // f_e(n), on the hand
};

}  // namespace feltwire
