#pragma once
// A simulated hand that a person steers with a gamepad or a 3D mouse. The person feels nothing; the
// hand feels the scene, so that the tool is held back by what it touches.

#include <filesystem>
#include <string>
#include <vector>

#include "client/devices/drivers.hpp"
#include "client/devices/hand_device.hpp"
#include "client/devices/plugged_in.hpp"
#include "client/devices/steering.hpp"

namespace feltwire {

struct SteeredHandOptions {
  DeviceSpec spec;  // of the simulated device in the hand
  Hand hand;
  SteeringOptions steering;
  double reach = 0.02;  // [m] at most, from the hand to where it means to be: so it presses with
                        // stiffness * reach
  double wrist_reach = 0.3;  // [rad] likewise
  double clearance = 0.02;   // [m] from the surface where begin() puts it
};

/// The axes tell a velocity of where the hand means to be, and of how it means to be turned. An
/// input device that was unplugged is a fault for good.
class SteeredDevice final : public HandDevice {
 public:
  /// `kind` is "gamepad" or "spacemouse". Throws std::runtime_error where the node is of another
  /// kind, std::invalid_argument where a number is not usable.
  SteeredDevice(EventNode node, std::string_view kind, const SteeredHandOptions& options);

  /// Puts the hand before the surface.
  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;

 private:
  Vec3 intended(double time) noexcept override;
  Vec3 intended_turn(double time) noexcept override;
  void take_events(Nanoseconds now) noexcept;

  EventNode node_;
  SteeredHandOptions options_;
  InputState input_;
  Steering steering_;
  Vec3 aim_ = Vec3::Zero();                         // where the hand means to be [m]
  Quaternion turned_aim_ = Quaternion::Identity();  // how it means to be turned
  double moved_until_ = 0.0, turned_until_ = 0.0;   // [s]
  bool gone_ = false;
};

/// The input device that `name` says, as "event5" or a path; empty: the only one of that kind there
/// is. Throws std::runtime_error that says what was looked for and the remedy.
std::filesystem::path input_node(const Machine& machine, std::string_view kind,
                                 const std::string& name);

/// Throw likewise.
OpenedDevice open_gamepad(const DeviceRequest& request);
OpenedDevice open_spacemouse(const DeviceRequest& request);

}  // namespace feltwire
