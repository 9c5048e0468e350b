#pragma once
// What a test tells the stand-in of libdrd, and sees of it. The library exports stand_in_new().

#include <atomic>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each reading is a period after the one before.
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
  int devices = 1;  // all with the one mass
  bool left_handed = false;
  int off_cause = 1;  // what switches the force off between these readings: the button
  bool plugged = true, initialized = true, wrist = true, active_wrist = false;
  double gap = -1.0;                       // [m] of the gripper; below zero: it has none
  int stale_every = 0;                     // readings; 0: never
  double saturates_at = 1e9;               // [N]
  double turns_at_most = 1e9;              // [N m]
  long fails_from = -1, fails_until = -1;  // readings between which every call fails
  long off_from = -1, off_until = -1;      // and between which the forces are switched off
  bool watchdog_works = true, gravity_works = true, tells_force = true;
  std::atomic<bool> blocks{false}, blocked{false};

  long readings = 0;
  int opened = 0, closed = 0, stopped = 0;
  bool grips = false;  // a force of the gripper was set
  bool force_on = false, brakes_on = true, gravity_on = false, force_before_on = false;
  unsigned char watchdog = 0;
  bool watched_off = false;  // the watchdog has switched the force off, until it is enabled again
  int strangers = 0;         // calls for a device that was not opened
  double max_force = -1.0, max_torque = -1.0;
  double most_made = 0.0;  // [J] by force and torque together, beyond what both burned
  std::atomic<bool> pulls{false};
  std::atomic<unsigned> buttons{0};  // a bit each
  std::atomic<int> zeros{0};         // forces of nothing that were set
};

}  // namespace stand_in
