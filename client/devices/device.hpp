#pragma once
// The interface of a haptic device. Implement it to attach one (docs/devices.md).

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// What read() returns.
struct DeviceReading {
  Pose pose;           // of the tool, world frame
  bool ok = true;      // false: the device has a fault; the servo gives zero force and reports it
  bool ended = false;  // no more readings will come (a recording is over)
};

/// A haptic device. The servo thread calls read() and then write(), once each tick; no other thread
/// calls them. Neither may block, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  /// The specification. It must not change.
  virtual const DeviceSpec& spec() const = 0;

  /// Called once, before the first read(), by the thread that joined. The arguments say where a
  /// hand that does not know the scene should begin: a point [m] on a surface and the unit normal
  /// there, world frame. Simulated hands go there; a real device can ignore it. If it throws, the
  /// run does not begin.
  virtual void begin(const Vec3& /*position*/, const Vec3& /*normal*/) {}

  /// Returns where the tool is at `now`, a monotonic time. A simulated device moves up to that
  /// time.
  virtual DeviceReading read(Nanoseconds now) noexcept = 0;

  /// Holds this command on the hand until the next write(). It is within the spec's limits already.
  /// Returns the command that is really held, which may be less (a fault, an amplifier's limit).
  /// Only that is accounted.
  virtual Command write(const Command& on_hand) noexcept = 0;

  /// Takes the force off the hand for good. Later calls of write() must hold nothing. It is called
  /// when the run ends, when the servo thread makes no ticks, and when the program crashes. Any
  /// thread and any signal handler may call it, more than once, also while read() or write() runs
  /// in another thread or has crashed in this one. So it must be async-signal-safe
  /// (signal-safety(7)): no lock, no allocation, no waiting for read() or write(). A system call on
  /// the device's descriptor is fine, and so is an atomic flag that a thread of the driver acts on.
  virtual void release() noexcept = 0;
};

}  // namespace feltwire
