#pragma once
// The bench: a hand with a device, a robot, its surroundings and a network between them, in one
// degree of freedom and virtual time. Positions grow into the wall [m].

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/emulated_link/link_options.hpp"
#include "client/hands/simulated_device.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

inline constexpr double kGravity = 9.81;         // [m/s^2]
inline constexpr double kVelocityCutoff = 60.0;  // [Hz] of the low-pass of the hand's velocity
inline constexpr int kParts = 10;                // of a servo sample, for the integration

/// The surroundings of the robot: a wall that may move and vanish, or a weight on the ground.
struct Surroundings {
  enum class Kind : std::uint8_t { nothing, wall, weight };
  Kind kind = Kind::wall;
  double stiffness = 2000.0, damping = 2.0;  // [N/m], [N s/m]
  double swing = 0.0, frequency = 1.0;       // [m], [Hz] of a wall that moves
  double moves_from = 0.0;                   // [s]
  double vanishes = 1e9;                     // [s]
  double mass = 0.15;                        // [kg] of a weight
};

/// The intended place of the hand at this time [m].
using Intention = std::function<double(double time)>;

struct BenchSetup {
  Plant plant;
  Hand hand{.mass = 0.1, .damping = 5.0, .stiffness = 300.0};
  Surroundings around;
  Intention intention;
  double duration = 8.0;                   // [s]
  LinkOptions link;                        // of each direction
  double cut_from = 1e9, cut_until = 1e9;  // [s] no datagram sent in between arrives
  std::uint64_t seed = 1;
  double wrench_noise = 0.01;  // [N] RMS of the robot's sensor
};

/// A servo sample; forces on the hand as F, which resists it.
struct BenchSample {
  double hand = 0.0, shown = 0.0;  // [m] true; as the encoder reports
  double held = 0.0;               // [N] F until this sample
  double robot = 0.0;              // [m]
  double offset = 0.0;             // [m] of the law
  double surface = 0.0;            // [m] place of the wall, or of the lower side of the weight
  double contact = 0.0;            // [N] of the environment against the robot
  double pushed = 0.0;  // [J] sum over the contacts of the largest net energy that each gave
};

/// Runs a law from time 0. Deterministic: the same setup gives the same bits.
std::vector<BenchSample> run_bench(TeleoperationLaw& law, const BenchSetup& setup);

}  // namespace feltwire::teleop
