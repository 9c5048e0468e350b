#pragma once
// A simulated hand in a scene behind a bounding method, in process and deterministic.

#include <functional>
#include <optional>
#include <vector>

#include "client/hands/simulated_device.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// The walls whose forces add up to the command at a place [m].
using WallsTouched = std::function<ContactNormals(const Vec3&)>;

struct ExperimentSetup {
  SimulatedHandOptions hand;
  BoundingConfig bounding;
  const BoundingMethod* law = nullptr;   // replaces the method that bounding.mode names
  std::optional<AccountConfig> account;  // after the bound; empty: none
  int delay = 0;          // [T] a round trip: age of the position that a command was computed from
  double duration = 8.0;  // [s]
  double velocity_cutoff =
      0.0;                  // [Hz] of the velocity that damping and viscous friction see; 0: none
  WallsTouched walls = {};  // empty: the bound does not know the walls
};

/// A servo sample. Forces on the hand.
struct ExperimentSample {
  double time = 0.0;                 // [s]
  Vec3 position = Vec3::Zero();      // [m] true, of the handle
  Vec3 motor = Vec3::Zero();         // [m] true, of the motor
  Vec3 displacement = Vec3::Zero();  // [m] as the encoders report
  Command commanded, rendered;       // f_e(n), f_d(n)
  Vec3 held = Vec3::Zero();          // [N] f_d(n-1), which acted during the displacement
  bool in_debt = false;              // of the account
  TrueEnergy energy;                 // until now
};

/// The environment of a hand: the force on the hand for a tool, once a sample in their order. It
/// keeps its own memory of the tool; a copy copies that.
using Environment = std::function<Command(const Tool&)>;

/// A scene as one tool's environment, in a fresh state. The scene must outlive it.
Environment environment(const Scene& scene);

/// The bound of a setup, in a fresh state. Throws std::invalid_argument.
Bounding bounding_of(const ExperimentSetup& setup);

/// A delay [s] in whole samples of `period` [s], rounded up, because a command arrives at a sample.
int delay_samples(double delay, double period);

/// Reads the device every T, asks the environment, bounds, writes; one sample each, from time 0 to
/// `duration`. The environment is copied, so that it stays in the state it was given in. Throws
/// std::invalid_argument for a setup that cannot be run.
std::vector<ExperimentSample> run_experiment(const Environment& environment,
                                             const ExperimentSetup& setup);
std::vector<ExperimentSample> run_experiment(const Scene& scene, const ExperimentSetup& setup);

}  // namespace feltwire
