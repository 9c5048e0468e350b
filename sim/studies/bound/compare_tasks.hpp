#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/measure/experiment.hpp"

namespace feltwire {

/// A surface, and the movement of a hand on it.
struct CompareTask {
  std::string name;                             // one word
  Environment touch;                            // in a fresh state
  std::function<double(const Vec3&)> distance;  // [m] from the surface, negative inside
  HandTask hand;
  double duration = 8.0;    // [s]
  WallsTouched walls = {};  // if there are several
};

/// The paper's wall and sphere, a corner, a sharp edge, a bumpy torus, stick-slip, a tap
/// (docs/lab/laboratory.md has their numbers).
std::vector<CompareTask> compare_tasks();

}  // namespace feltwire
