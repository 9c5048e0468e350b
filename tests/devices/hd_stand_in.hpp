#pragma once
// A test's settings for the stand-in of libHD, and its results. It exports stand_in_new().

#include <atomic>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// Its scheduler runs at 1 kHz, and the mass moves by that clock. If the machine delays a tick, the
/// mass moves by 1.25 ms at most. In virtual time the scheduler runs as fast as it can, and the
/// mass moves by 1 ms each tick.
struct Hd {
  SimulatedMass mass;  // read it when the scheduler is stopped
  ForceEdge edge;      // of the requested forces
  const char* model = "Touch";
  const char* known = "";  // the only name that opens; empty: the default device
  bool plugged = true;
  unsigned calibration = 0x5000, style = 4;
  std::atomic<unsigned> raises{0};  // the next frame puts this error on the stack, twice
  std::atomic<unsigned> fails{0};   // every frame has this error
  std::atomic<bool> blocks{false};  // a frame does not end
  std::atomic<bool> stuck{false};   // the scheduler calls nothing

  std::atomic<bool> inkwell{false};         // the stylus is in it
  std::atomic<double> asked_in_inkwell{0};  // [N] largest requested force meanwhile

  bool virtual_time = false;       // set it before the scheduler runs
  std::atomic<double> told_at{0};  // [s] mass time of the last reported place

  std::atomic<int> frames{0};
  std::atomic<int> buttons{0};                               // a bit each
  std::atomic<double> force{0.0};                            // [N] of the last frame
  int output_dof = 3;                                        // 6: it has motors at the wrist
  Three torque{};                                            // [N m] of the last frame, in our axes
  std::atomic<double> largest_torque{0.0}, about_near{0.0};  // [N m] largest, and about x
  std::atomic<double> told_near{0.0};      // [m] last reported place, towards the user
  std::atomic<double> asked_ramping{0.0};  // [N] largest requested force during a ramp
  int opened = 0, closed = 0, updates = 0;
  bool force_on = false;
  int misuses = 0;  // calls at a place that the guide forbids
};

}  // namespace stand_in
