#pragma once
// A device whose workspace is mapped into the scene by scale, rotation, mirror and translation. A
// clutch lifts it off the scene, as one lifts a mouse off a table.

#include <memory>
#include <optional>

#include "client/device/command_delay.hpp"
#include "client/device/device.hpp"

namespace feltwire {

/// Maps the place x_d of the device to the place x = s M x_d + t of the scene. M = R D, with R the
/// rotation and D the mirror.
struct WorkspaceMapping {
  double scale = 1.0;                  // s: metres of the scene for one metre of the device
  Vec3 rotation = Vec3::Zero();        // [rad] rotation vector of R
  Vec3 translation = Vec3::Zero();     // t [m]
  std::optional<int> mirrored_axis{};  // the axis of the device, 0 to 2, that D reverses

  /// Returns M, which is orthogonal. Quarter turns are exact.
  Mat3 axes() const;
};
/// Throws std::invalid_argument that names the option and the remedy.
void validate(const WorkspaceMapping& mapping);

/// Returns the specification of the device in the scene's axes. Its power is the same at every
/// moment (docs/devices.md has the derivation): damping M B M' / s^2, masses / s^2, forces / s,
/// lengths and speeds times s. The numbers of rotation are turned, not scaled. The quantum of an
/// encoder is s q |M'|_1, which covers the turned grid. Throws std::invalid_argument if a number
/// leaves its range.
DeviceSpec mapped_spec(const DeviceSpec& device, const WorkspaceMapping& mapping);

/// The device behind the mapping. Orientations turn with the axes, so an upright device is upright
/// in the scene. Forces are mapped back by the transpose: f_d = s M' f, and the torque is det(M) M'
/// tau.
///
/// The clutch (DeviceReading::clutch): while it is held the servo asks for no force. As soon as the
/// device holds none, the tool stands still (DeviceReading::clutched), and the hand can move
/// freely. After the release the tool continues from exactly the same place.
class MappedDevice final : public Device {
 public:
  /// Throws like validate() and mapped_spec().
  MappedDevice(std::unique_ptr<Device> device, const WorkspaceMapping& mapping);

  const DeviceSpec& spec() const override { return spec_; }
  double motion_scale() const override { return scale_ * device_->motion_scale(); }
  void begin(const Vec3& position, const Vec3& normal) override;
  Nanoseconds longest_tick() const override { return device_->longest_tick(); }
  bool await_tick(Nanoseconds latest) noexcept override { return device_->await_tick(latest); }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override;
  std::string_view prepare() noexcept override { return device_->prepare(); }
  bool lower_tool(Nanoseconds now) noexcept override { return device_->lower_tool(now); }
  void release() noexcept override { device_->release(); }

 private:
  enum class Tool : std::uint8_t {
    led,     // the hand leads the tool
    let_go,  // the hand leads the tool; no force is asked for, but the device may still hold some
    halted,  // no force was held during the last movement, which still counts; the tool stands from
             // here on
    standing,  // the tool stands, and the hand moves without it
  };
  Pose in_scene(const Pose& pose) const noexcept;
  Command to_scene(const Command& command) const noexcept;
  Command to_device(const Command& command) const noexcept;
  void clutch(DeviceReading& reading, bool holds) noexcept;

  std::unique_ptr<Device> device_;
  double scale_;
  Mat3 axes_;       // M
  double turning_;  // det(M): -1 for a mirror, which reverses rotations
  DeviceSpec spec_;

  // Members of the servo's thread.
  Pose hand_, tool_;  // the tool's pose, and the hand's pose at the same moment
  Tool state_ = Tool::led;
  CommandDelay command_delay_;  // of what it wrote, in the device's own axes
};

}  // namespace feltwire
