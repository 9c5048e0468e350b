#pragma once
// What a test tells the stand-in of libusb with a Falcon on it, and sees of it. The library exports
// stand_in_new().

#include <atomic>
#include <cstdint>
#include <vector>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each request that its firmware understands is a tick of a millisecond. The
/// mass's axes are x towards the user, y right, z up, from 120 mm before the legs' middle.
struct Falcon {
  SimulatedMass mass;  // look at it when nobody asks
  ForceEdge edge;
  bool plugged = true, accessible = true, busy = false;
  int devices = 1;
  bool loaded = true;                // the firmware runs
  std::vector<std::uint8_t> wanted;  // the image that runs where it is loaded
  int hello_misses = 0;              // hellos that the boot loader does not answer
  int wrong_echoes = 0;              // loads in which one byte is echoed wrongly
  bool refuses_load = false;         // it answers the load's first byte by another

  std::atomic<bool> blocks{false};   // transfers do not return
  std::atomic<bool> unplug{false};   // from now on every transfer fails
  std::atomic<int> short_writes{0};  // writes of which half is taken
  std::atomic<int> drops{0};         // requests that are not seen
  std::atomic<int> garbles{0};       // answers in which one byte is another
  std::atomic<int> wrong_ends{0};    // answers that do not end
  std::atomic<int> jumps{0};         // answers of an arm that is elsewhere
  std::atomic<int> late{0};          // answers that come 30 ms late
  std::atomic<int> repeats{0};       // answers that come twice
  std::atomic<bool> in_pieces{false};
  std::atomic<int> homed{7};    // a bit each leg
  std::atomic<int> buttons{0};  // a bit each

  std::atomic<int> requests{0}, loads{0}, opened{0}, closed{0}, lights{0};
  std::atomic<bool> homing{false};          // as the newest request asks
  std::atomic<double> force{0.0};           // [N] on the mass
  std::atomic<int> largest_motor{0};        // of all requests
  std::atomic<int> motor_before_homing{0};  // the largest while a leg was not homed
  std::atomic<int> misuses{0};              // calls that make no sense
};

}  // namespace stand_in
