#pragma once
// A test's settings for the stand-in plugin, and its results. The plugin exports stand_in().

#include <atomic>
#include <cstdint>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each wait() is a tick.
struct Plugin {
  SimulatedMass mass;
  ForceEdge edge;
  double period = 1e-3;             // [s]
  double jitter = 0.0;              // [s] by which a tick comes early, at most
  double late = 0.0;                // share of a tick during which the old force stays
  int late_ticks = 0;               // its declared late ticks
  std::uint32_t buttons = 0;        // buttons held now
  double lever = -1.0;              // [m]; < 0: no lever
  double lag = -1.0;                // [s] of the motors, as it tells; < 0: not known
  int lag_kind = 0;                 // FELTWIRE_LAG_...
  double stiffness = -1.0;          // [N/m] of the transmission, as it tells; < 0: not known
  int encoder_side = 0;             // FELTWIRE_ENCODER_...
  std::uint32_t missing_bytes = 0;  // at the end of its table, as of an older header
  bool tells_late = true;           // it reports held forces
  int stale_every = 0;              // ticks; 0: never
  double saturates_at = 1e9;        // [N]
  bool turns = false;               // its wrist has motors
  double turns_at_most = 1e9;       // [N m]
  Three torque{};                   // [N m] held torque
  std::int64_t unplugged_at = -1;   // tick; -1: never
  std::atomic<bool> blocks{false};  // read() does not return while it is set
  std::atomic<bool> blocked{false};

  std::uint32_t version = 1;
  const char* null_function = "";
  const char* open_error = "";  // open() fails with this
  const char* source = "the stand-in itself";

  std::int64_t ticks = 0;
  std::atomic<int> releases{0}, closes{0};
  std::atomic<bool> pulls{false};
};

}  // namespace stand_in

extern "C" {
/// Makes the only device anew.
using NewStandIn = stand_in::Plugin*();
}
