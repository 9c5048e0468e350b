#pragma once
// The bench in three degrees of freedom: hand, device, robot and network of bench.hpp, and a shape
// that the robot's tip touches. All of them are points and have the same properties in every
// direction.

#include <functional>
#include <vector>

#include "sim/studies/teleop/bench.hpp"
#include "sim/studies/teleop/space_shapes.hpp"
#include "sim/teleoperation_laws/spatial_law.hpp"

namespace feltwire::teleop::in_space {

/// The intended place of the hand at this time [m].
using SpaceIntention = std::function<Vec3(double time)>;

struct SpaceSetup {
  Plant plant;
  Hand hand{.mass = 0.1, .damping = 5.0, .stiffness = 300.0};
  Shape around;
  SpaceIntention intention;
  double duration = 8.0;  // [s]
  LinkOptions link;       // of each direction
  std::uint64_t seed = 1;
  double wrench_noise = 0.01;  // [N] RMS of the robot's sensor, on each axis
};

/// A servo sample; forces on the hand as F, which resists it.
struct SpaceSample {
  Vec3 hand = Vec3::Zero(), shown = Vec3::Zero();  // [m] true; as the encoder reports
  Vec3 held = Vec3::Zero();                        // [N] F until this sample
  Vec3 robot = Vec3::Zero();                       // [m]
  Vec3 offset = Vec3::Zero();                      // [m] of the law
  Vec3 contact = Vec3::Zero();                     // [N] of the environment on the robot
  double pushed = 0.0;  // [J] sum over the contacts of the largest net energy that each gave
};

/// Runs a law from time 0. Deterministic: the same setup gives the same bits.
std::vector<SpaceSample> run_space_bench(SpatialLaw& law, const SpaceSetup& setup);

}  // namespace feltwire::teleop::in_space
