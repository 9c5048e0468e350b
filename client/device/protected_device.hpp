#pragma once
// A device with a start that does not kick, an emergency stop, a tool whose weight is held, and
// buttons that the user chose.

#include <atomic>
#include <memory>
#include <optional>

#include "client/device/device.hpp"

namespace feltwire {

/// The emergency stop of one device: a person presses it, and it stays pressed until it is reset.
class EmergencyStop {
 public:
  /// Any thread, any signal handler.
  void press() noexcept { pressed_.store(true); }
  void reset() noexcept { pressed_.store(false); }
  bool pressed() const noexcept { return pressed_.load(); }

 private:
  std::atomic<bool> pressed_{false};
  static_assert(std::atomic<bool>::is_always_lock_free);
};

struct ProtectionOptions {
  double tool_weight = 0.0;  // [N] of a tool at the handle; it pulls along -z of the device
  int emergency_button = 0;  // of the device, counted from 1; 0: none
  double still = 0.0;  // [s] that the hand must be still before the first force; 0: not at all
  // The enabling switch and the clutch: buttons of the device, counted from 1. 0: no button. Empty:
  // as the driver has them.
  std::optional<int> deadman_button{}, clutch_button{};
};

/// The device with the tool, whose weight is held: a part of its greatest force is taken for that,
/// and the hand may pull harder by as much, since a weight that was given wrongly pulls, too.
/// Throws std::invalid_argument with the option's name and the remedy.
DeviceSpec protected_spec(const DeviceSpec& device, const ProtectionOptions& options);

/// Forces are withheld (DeviceReading::withheld) at the start, after the inkwell and after an
/// emergency stop, until the hand was within 3 mm for the time `still`, or the enabling switch is
/// pressed. Then the weight of the tool is taken up within half a second, and forces are let
/// through. After a fault the weight is taken up anew.
///
/// The weight of the tool is a constant force W = (0, 0, tool_weight) on the handle. write() and
/// DeviceReading::held tell what the device holds less W. So what the account does not see is the
/// work of W along the way, W (x - x_0), which depends on the place alone: over each closed way it
/// is zero, however the path is sampled. While the weight is being taken up or let down, nothing
/// is accounted.
///
/// The emergency stop takes off all force, that of the weight too, at the next tick.
class ProtectedDevice final : public Device {
 public:
  /// Throws as protected_spec() does. `emergency` must not be null.
  ProtectedDevice(std::unique_ptr<Device> device, const ProtectionOptions& options,
                  std::shared_ptr<EmergencyStop> emergency);

  const DeviceSpec& spec() const override { return spec_; }
  double motion_scale() const override { return device_->motion_scale(); }
  std::string_view prepare() noexcept override { return device_->prepare(); }
  void begin(const Vec3& position, const Vec3& normal) override {
    device_->begin(position, normal);
  }
  Nanoseconds longest_tick() const override { return device_->longest_tick(); }
  bool await_tick(Nanoseconds latest) noexcept override { return device_->await_tick(latest); }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override;
  /// Within half a second.
  bool lower_tool(Nanoseconds now) noexcept override;
  void release() noexcept override { device_->release(); }

 private:
  enum class Stage : std::uint8_t { moving, rising, open };
  void take_up(Nanoseconds now) noexcept;
  bool still(const DeviceReading& reading, Nanoseconds now) noexcept;
  Command less_weight(const Command& held) const noexcept;
  Vec3 weight() const noexcept { return {0.0, 0.0, share_ * options_.tool_weight}; }

  std::unique_ptr<Device> device_;
  ProtectionOptions options_;
  std::shared_ptr<EmergencyStop> emergency_;
  DeviceSpec spec_;

  // Members of the servo's thread.
  Stage stage_ = Stage::moving;
  double share_ = 0.0;  // of the weight that is held now
  bool lowering_ = false;
  Pose pose_;                         // that the device told last
  Nanoseconds changed_{0};            // when the share was last changed
  Vec3 still_at_ = Vec3::Zero();      // [m]
  std::optional<Nanoseconds> since_;  // that it has been there
};

}  // namespace feltwire
