// A bound without a session. A wall of 1 kN/m is softer than 2 b / T = 4 kN/m, so the hand gets the
// complete force.

#include <cstdio>
#include <feltwire/core/bounding/bounding.hpp>

int main() {
  feltwire::BoundingConfig config;
  config.period = 1e-3;                     // [s]
  config.damping = feltwire::Damping(2.0);  // [N s/m] damping of the device
  feltwire::Bounding bounding(config);
  feltwire::BoundingStep step;
  step.displacement = feltwire::Vec3(0.0, 0.0, -1e-3);
  step.command.elastic = feltwire::Vec3(0.0, 0.0, 1.0);
  const double force = bounding.step(step).rendered.elastic.z();
  std::printf("%.6f N\n", force);
  return force == 1.0 ? 0 : 1;
}
