#pragma once
// The specification of a haptic device, for the server and the bound.

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/base/types.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

/// How a motor's force follows its command (core/bounding/lagging_forces.hpp): with a delay or any
/// response that ends within the time; with a first-order lag of that time constant; or with a
/// delay and then a first-order lag, which make up the time together.
enum class LagKind : std::uint8_t { delay, filter, mixed };
inline constexpr std::array<std::string_view, 3> kLagKindNames = {"delay", "filter", "mixed"};

/// The body that the encoder measures: before or behind the transmission.
enum class EncoderSide : std::uint8_t { motor, handle };
inline constexpr std::array<std::string_view, 2> kEncoderSideNames = {"motor", "handle"};

/// How late a written force comes on the hand. Both add up.
struct ActuationSpec {
  int late_ticks = 0;  // after which the device takes up a force that is written
  double lag = 0.0;    // L [s] upper bound of the time by which the motor's force follows that,
                       // without late ticks write(); 0: none is told
  LagKind kind = LagKind::delay;
};

/// Between motor and handle. No bound uses it: it says what of a wall the hand can feel.
struct TransmissionSpec {
  double stiffness = 0.0;                         // k_t [N/m] lower bound; 0: rigid, or not known
  EncoderSide encoder_side = EncoderSide::motor;  // the bounds hold at the motor alone
};

/// The numbers of a DeviceSpec for rotation.
struct RotationSpec {
  double resolution = 0.0;     // [rad] encoder quantum about each world axis
  double least_inertia = 0.0;  // [kg m^2] lower bound of the apparent inertia about every axis, the
                               // least eigenvalue of its matrix; 0: not known
  double hand_torque = 0.0;    // [N m] upper bound of the torque from outside; 0: not known
  // For a simulated device. The account does not use them.
  double inertia = 0.0;   // [kg m^2] at the tool, the same about every axis
  double friction = 0.0;  // [N m] dry friction about each world axis
};

/// Limits and physics of one device. The files of the built-in devices (core/device/*.json) have
/// the source of each number.
struct DeviceSpec {
  std::string name;
  int translation_dof = 3;           // 2 (x, y) or 3 (x, y, z), sensed and actuated
  int rotation_sensed = 0;           // 0 or 3
  int rotation_actuated = 0;         // 0 or 3; never more than sensed
  Damping damping;                   // B [N s/m], the device's own physical damping
  Damping rotational_damping;        // B_r [N m s/rad]
  double apparent_mass = 0.0;        // [kg] at the tool
  double coulomb_friction = 0.0;     // [N] at the tool
  double position_resolution = 0.0;  // [m] encoder quantum at the tool
  double max_force = 0.0;            // [N] peak
  double continuous_force = 0.0;     // [N]
  double max_torque = 0.0;           // [N m] peak, 0 if torque is not actuated
  Vec3 workspace = Vec3::Zero();     // [m] full extent along x, y, z

  // Assumptions of the port's account (core/bounding/account.hpp). They stay at the client.
  double least_mass = 0.0;      // [kg] lower bound of the apparent mass in every direction, the
                                // least eigenvalue of its matrix; 0: not known
  double least_friction = 0.0;  // [N] lower bound of the dry friction; 0: not known
  double hand_force = 10.0;     // [N] upper bound of the force from outside: of the hand, and of
                                // gravity that is not compensated
  double hand_speed = 0.0;      // [m/s] upper bound of the handle's speed; 0: not known
  ActuationSpec actuation{};
  TransmissionSpec transmission{};
  RotationSpec rotation{};
};

/// The most that ActuationSpec::late_ticks can be.
inline constexpr int kMostLateTicks = 4;

/// A number of a specification that is not finite, negative or contradictory: what() names the
/// device, the field and the remedy.
struct DeviceSpecError : std::invalid_argument {
  DeviceSpecError(const std::string& device, std::string in_field, std::string says)
      : std::invalid_argument("device '" + device + "': " + in_field + ": " + says),
        field(std::move(in_field)),
        why(std::move(says)) {}
  std::string field, why;
};

/// Throws DeviceSpecError.
void validate(const DeviceSpec& spec);

/// The built-in devices, in a fixed order.
std::span<const DeviceSpec> builtin_devices();

/// The built-in device of that name; throws std::invalid_argument that lists the existing names.
const DeviceSpec& builtin_device(std::string_view name);

/// The part of a command that the device can actuate: missing axes become zero.
Command actuated(const DeviceSpec& spec, Command command) noexcept;

}  // namespace feltwire
