#pragma once
// A device whose workspace is mapped into the scene: scaled, turned, mirrored, shifted, and lifted
// off the scene by a clutch, as a mouse is off its table.

#include <memory>
#include <optional>

#include "client/devices/device.hpp"

namespace feltwire {

/// A place x_d of the device is the place x = s M x_d + t of the scene, M = R D: R the rotation, D
/// the mirror.
struct WorkspaceMapping {
  double scale = 1.0;                  // s: metres of the scene a metre of the device
  Vec3 rotation = Vec3::Zero();        // [rad] rotation vector of R
  Vec3 translation = Vec3::Zero();     // t [m]
  std::optional<int> mirrored_axis{};  // of the device, 0 to 2, whose sense D turns round

  /// M: orthogonal. Quarter turns are exact.
  Mat3 axes() const;
};
/// Throws std::invalid_argument with the option's name and the remedy.
void validate(const WorkspaceMapping& mapping);

/// The device as the scene sees it, of the same power at every moment (docs/devices.md has the
/// derivation): damping M B M' / s^2, masses / s^2, forces / s, lengths and speeds s; the numbers
/// of rotation turned, not scaled. An encoder's quantum is s q |M'|_1, which has the turned grid in
/// it. Throws std::invalid_argument where a number leaves its range.
DeviceSpec mapped_spec(const DeviceSpec& device, const WorkspaceMapping& mapping);

/// The device behind the mapping. Orientations are turned with the axes, so that what is upright in
/// the device's axes is so in the scene's. Forces go back by the transpose: f_d = s M' f, and the
/// torque det(M) M' tau.
///
/// The clutch (DeviceReading::clutch): once it is held no force is asked for. As soon as the device
/// holds none the tool stands still (DeviceReading::clutched), wherever the hand goes. When it is
/// let go, the tool goes on from exactly where it stood.
class MappedDevice final : public Device {
 public:
  /// Throws as validate() and mapped_spec() do.
  MappedDevice(std::unique_ptr<Device> device, const WorkspaceMapping& mapping);

  const DeviceSpec& spec() const override { return spec_; }
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
    led,       // by the hand
    let_go,    // likewise: no force is asked for, but some may still be held
    halted,    // nothing was held on its last way, which is told; from here on it stands
    standing,  // and the hand moves without it
  };
  Pose in_scene(const Pose& pose) const noexcept;
  Command to_scene(const Command& command) const noexcept;
  Command to_device(const Command& command) const noexcept;
  void clutch(DeviceReading& reading, const Command& held) noexcept;

  std::unique_ptr<Device> device_;
  double scale_;
  Mat3 axes_;       // M
  double turning_;  // det(M): turns of a mirrored hand go the other way round
  DeviceSpec spec_;

  // Of the servo's thread.
  Pose hand_, tool_;  // where the tool was when the hand was there
  Tool state_ = Tool::led;
  Command held_;  // by the device, as it said last; in its own axes
};

}  // namespace feltwire
