#pragma once
// A simulated hand that a person steers with a gamepad or a 3D mouse. The person feels nothing. The
// simulated hand feels the scene, so surfaces hold the tool back.

#include <filesystem>
#include <string>
#include <vector>

#include "client/drivers/common/driver.hpp"
#include "client/hands/hand_device.hpp"
#include "client/input_devices/steering.hpp"
#include "client/input_devices/usb_scan.hpp"

namespace feltwire {

struct JoystickHandOptions {
  DeviceSpec spec;  // of the simulated device in the hand
  Hand hand;
  SteeringOptions steering;
  double reach = 0.02;  // [m] largest distance from the hand to the intended place: it presses with
                        // stiffness * reach
  double wrist_reach = 0.3;  // [rad] the same for the wrist
  double clearance = 0.02;   // [m] distance from the surface of the place where begin() puts it
};

/// The axes give a velocity of the intended place, and of the intended orientation. An unplugged
/// input device is a permanent fault.
class JoystickDevice final : public HandDevice {
 public:
  /// `kind` is "gamepad" or "spacemouse". Throws std::runtime_error if the node is of another kind,
  /// std::invalid_argument if a number is not usable.
  JoystickDevice(EventNode node, std::string_view kind, const JoystickHandOptions& options);

  /// Puts the hand in front of the surface.
  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;

 private:
  Vec3 intended(double time) noexcept override;
  Vec3 intended_turn(double time) noexcept override;
  void take_events(Nanoseconds now) noexcept;

  EventNode node_;
  JoystickHandOptions options_;
  InputState input_;
  Steering steering_;
  Vec3 aim_ = Vec3::Zero();                         // [m] intended place
  Quaternion turned_aim_ = Quaternion::Identity();  // intended orientation
  double moved_until_ = 0.0, turned_until_ = 0.0;   // [s]
  bool gone_ = false;
};

/// Opens the input device `name`, "event5" or a path. Empty: the only one of that kind. Throws
/// std::runtime_error that names the searched nodes and the remedy.
std::filesystem::path input_node(const Machine& machine, std::string_view kind,
                                 const std::string& name);

/// They throw the same.
OpenedDevice open_gamepad(const DeviceRequest& request);
OpenedDevice open_spacemouse(const DeviceRequest& request);

}  // namespace feltwire
