#pragma once
// A test's settings for the stand-in of libusb with a Falcon, and its results. The library exports
// stand_in_new().

#include <atomic>
#include <cstdint>
#include <vector>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each request that its firmware understands is a tick of 1 ms. The mass's axes
/// are x towards the user, y right, z up; its origin is 120 mm before the legs' middle.
struct Falcon {
  SimulatedMass mass;  // read it when nothing sends requests
  ForceEdge edge;
  bool plugged = true, accessible = true, busy = false;
  int devices = 1;
  bool loaded = true;                // the firmware runs
  std::vector<std::uint8_t> wanted;  // the image that runs once it is loaded
  int hello_misses = 0;              // hellos that the boot loader ignores
  int wrong_echoes = 0;              // loads with a wrong echo byte
  bool refuses_load = false;         // it answers the first byte of a load wrongly

  std::atomic<bool> blocks{false};   // transfers do not return
  std::atomic<bool> unplug{false};   // all later transfers fail
  std::atomic<int> short_writes{0};  // writes of which only half is taken
  std::atomic<int> drops{0};         // requests that get lost
  std::atomic<int> garbles{0};       // answers with a wrong byte
  std::atomic<int> wrong_ends{0};    // answers without the end byte
  std::atomic<int> jumps{0};         // answers with an arm at another place
  std::atomic<int> late{0};          // answers that come 30 ms late
  std::atomic<int> repeats{0};       // answers that come twice
  std::atomic<bool> in_pieces{false};
  std::atomic<int> homed{7};    // a bit each leg
  std::atomic<int> buttons{0};  // a bit each

  std::atomic<int> requests{0}, loads{0}, opened{0}, closed{0}, lights{0};
  std::atomic<bool> homing{false};          // state that the newest request asks for
  std::atomic<double> force{0.0};           // [N] on the mass
  std::atomic<int> largest_motor{0};        // the largest of all requests
  std::atomic<int> motor_before_homing{0};  // the largest while a leg was not homed
  std::atomic<int> misuses{0};              // senseless calls
};

}  // namespace stand_in
