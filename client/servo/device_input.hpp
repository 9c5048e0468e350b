#pragma once
// First stage of a tick: the device's reading becomes a movement, or a fault.

#include "client/device/device.hpp"
#include "client/servo/servo_statistics.hpp"
#include "core/device/possible_movement.hpp"

namespace feltwire {

/// The part of the hold time for which a device may give nothing new, or no force, before it counts
/// as a fault.
inline constexpr double kDevicePatience = 0.25;

/// A reading as the next stages use it.
struct DeviceMovement {
  bool read = false;    // its position is usable
  bool jumped = false;  // no hand can have moved to its position
  bool fault = false;   // its position is not usable, and the device gives no reason for that
  bool known = false;   // the displacement was measured: the position before was usable, too
  Vec3 displacement = Vec3::Zero(), rotation = Vec3::Zero();  // [m], [rad] since the last tick
};

/// Judges one reading after another. Allocates, throws and reads a clock nowhere.
class DeviceInput {
 public:
  /// `motion_scale`: Device::motion_scale(). `rotation`: the bound uses rotations. `period`: T [s].
  DeviceInput(const DeviceSpec& spec, double motion_scale, bool rotation, double period)
      : moves_(position_bounds(spec, motion_scale)),
        turns_(rotation_bounds(spec)),
        senses_rotation_(spec.rotation_sensed != 0),
        rotation_(rotation),
        period_(period) {}

  /// Whether the servo makes no tick, because the device repeats its last reading. `since`: the
  /// last tick; `patience` [s]: for how long at most.
  bool waits(const DeviceReading& reading, double since, double patience,
             DeviceCounts& counts) const noexcept;

  /// Takes the reading of a tick, `elapsed` [s] after the one before. Across a fault no movement is
  /// known.
  DeviceMovement take(const DeviceReading& reading, double elapsed, DeviceCounts& counts) noexcept;

  /// The newest known pose.
  const Pose& pose() const noexcept { return pose_; }
  /// Whether pose() was read at the last tick.
  bool position_known() const noexcept { return position_known_; }
  /// Whether any reading had a pose.
  bool posed() const noexcept { return posed_; }
  /// The device reported its end.
  bool ended() const noexcept { return ended_; }
  /// [s] for which the device has given no usable position without a reason.
  double no_position_for() const noexcept { return no_position_for_; }

 private:
  bool jumps(const DeviceReading& reading, double elapsed) noexcept;
  void move_to(const DeviceReading& reading, DeviceMovement& movement) noexcept;

  PossibleMovement moves_, turns_;
  bool senses_rotation_, rotation_;
  double period_;
  Pose pose_;
  bool position_known_ = false, posed_ = false, ended_ = false;
  double no_position_for_ = 0.0;
};

}  // namespace feltwire
