#pragma once
// What a test tells the stand-in of libHD, and sees of it. The library exports stand_in_new().

#include <atomic>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// Its scheduler calls back a thousand times a second. The mass moves in the time of that clock; a
/// tick that the machine made longer is one of 1.25 ms for the mass. In virtual time it calls back
/// as fast as it can, and each tick is one of 1 ms for the mass.
struct Hd {
  SimulatedMass mass;  // read it when the scheduler does not run
  ForceEdge edge;      // of what is asked for
  const char* model = "Touch";
  const char* known = "";  // the one name that opens; empty: the default device
  bool plugged = true;
  unsigned calibration = 0x5000, style = 4;
  std::atomic<unsigned> raises{0};  // the next frame leaves this error on the stack, twice
  std::atomic<unsigned> fails{0};   // every frame leaves this error
  std::atomic<bool> blocks{false};  // a frame does not end
  std::atomic<bool> stuck{false};   // the scheduler calls nobody

  std::atomic<bool> inkwell{false};         // the stylus is in it
  std::atomic<double> asked_in_inkwell{0};  // [N] the most that was asked for meanwhile

  bool virtual_time = false;       // to be set before the scheduler runs
  std::atomic<double> told_at{0};  // [s] of the mass when its place was told last

  std::atomic<int> frames{0};
  std::atomic<int> buttons{0};                               // a bit each
  std::atomic<double> force{0.0};                            // [N] of the last frame
  int output_dof = 3;                                        // 6: it has motors at the wrist
  Three torque{};                                            // [N m] of the last frame, in our axes
  std::atomic<double> largest_torque{0.0}, about_near{0.0};  // [N m] the most, and about x
  std::atomic<double> told_near{0.0};      // [m] towards the user, the last that was told
  std::atomic<double> asked_ramping{0.0};  // [N] the most that was asked for while it ramped
  int opened = 0, closed = 0, updates = 0;
  bool force_on = false;
  int misuses = 0;  // calls that the guide forbids where they were made
};

}  // namespace stand_in
