#pragma once
// The interface of a haptic device. Implement it to attach one (docs/devices.md).

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct DeviceReading {
  Pose pose;           // of the tool, world frame
  bool ok = true;      // false: the device has a fault; the servo gives zero force and says so
  bool ended = false;  // the device has nothing more to say (a recording is over)
};

/// read() and write() are called from the servo thread only, read then write once a tick. Neither
/// may block, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceSpec& spec() const = 0;

  /// Told once, before the first read(), by the thread that joined: where a hand that knows nothing
  /// of the scene does well to begin (a point [m] of a surface and its unit normal, world frame).
  /// Simulated hands go there; a real device needs nothing of it. May throw: then there is no run.
  virtual void begin(const Vec3& /*position*/, const Vec3& /*normal*/) {}

  /// Where the tool is at `now` (monotonic since the first call; simulated devices move up to it).
  virtual DeviceReading read(Nanoseconds now) noexcept = 0;

  /// Hold this on the hand until the next write. Within the spec's limits already. Returns what is
  /// really held, which may be less (a device fault, an amplifier limit).
  virtual Command write(const Command& on_hand) noexcept = 0;

  /// Takes the force off the hand, now and for good: nothing is held from here on, whatever write()
  /// is told later. Called when the run ends, when the servo thread stands still, and when the
  /// program crashes: by any thread and by signal handlers, more than once, also while read() or
  /// write() is under way in another thread or has crashed in this one. It must be
  /// async-signal-safe (signal-safety(7)): it takes no lock, allocates nothing and does not wait
  /// for read() or write(). A system call on the device's descriptor is fine, and so is an atomic
  /// flag that a thread of the driver acts on.
  virtual void release() noexcept = 0;
};

}  // namespace feltwire
