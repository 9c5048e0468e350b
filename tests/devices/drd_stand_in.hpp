#pragma once
// A test's settings for the stand-in of libdrd, and its results. It exports stand_in_new().

#include <atomic>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each reading comes a period after the last one.
struct Drd {
  SimulatedMass mass;
  /// The wrist turns about z. Its numbers are [kg m^2], [N m s/rad], [N m] and [rad].
  SimulatedMass wrist_mass = inertia();
  static SimulatedMass inertia() {
    SimulatedMass turns;
    turns.mass = 3e-4, turns.damping = 1e-3, turns.friction = 0.005, turns.quantum = 2e-4;
    turns.stiffness = 0.5, turns.hand_damping = 5e-3;
    turns.depth = 0.2, turns.reach = 0.0;
    return turns;
  }
  ForceEdge edge;
  double period = 1e-3;  // [s]
  int major = 3, minor = 17;
  const char* system = "omega.7";
  int devices = 1;  // they share the mass
  bool left_handed = false;
  int off_cause = 1;  // cause of the force being off: the button
  bool plugged = true, initialized = true, wrist = true, active_wrist = false;
  double gap = -1.0;                       // [m] of the gripper; below zero: no gripper
  int stale_every = 0;                     // readings; 0: never
  double saturates_at = 1e9;               // [N]
  double turns_at_most = 1e9;              // [N m]
  long fails_from = -1, fails_until = -1;  // readings between which all calls fail
  long off_from = -1, off_until = -1;      // between which the forces are off
  bool watchdog_works = true, gravity_works = true, tells_force = true;
  std::atomic<bool> blocks{false}, blocked{false};

  long readings = 0;
  int opened = 0, closed = 0, stopped = 0;
  bool grips = false;  // a gripper force was set
  bool force_on = false, brakes_on = true, gravity_on = false, force_before_on = false;
  unsigned char watchdog = 0;
  bool watched_off = false;  // the watchdog holds the force off until it is enabled
  int strangers = 0;         // calls for a device that is not open
  double max_force = -1.0, max_torque = -1.0;
  double most_made = 0.0;  // [J] of force and torque together, beyond the burned energy
  std::atomic<bool> pulls{false};
  std::atomic<unsigned> buttons{0};  // a bit each
  std::atomic<int> zeros{0};         // number of zero forces set
};

}  // namespace stand_in
