#pragma once
// What a haptic device must do to be a client's hand. To attach one, implement this
// (docs/devices.md).

#include "core/device_spec.hpp"
#include "core/types.hpp"
#include "protocol/datagram.hpp"

namespace feltwire {

struct DeviceReading {
  Pose pose;           // of the tool, world frame
  bool ok = true;      // false: the device has a fault; the servo gives zero force and says so
  bool ended = false;  // the device has nothing more to say (a recording is over)
};

/// Called from the servo thread only, read then write once a tick. Neither may block, allocate or
/// throw.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceSpec& spec() const = 0;

  /// Where the tool is at `now` (monotonic since the first call; simulated devices move up to it).
  virtual DeviceReading read(Nanoseconds now) noexcept = 0;

  /// Hold this on the hand until the next write. Within the spec's limits already. Returns what is
  /// really held, which may be less (a device fault, an amplifier limit).
  virtual Command write(const Command& on_hand) noexcept = 0;
};

}  // namespace feltwire
