#include "core/device/device_spec.hpp"

#include <cmath>
#include <stdexcept>

namespace feltwire {
namespace {

// Largest accepted values. No haptic device reaches these limits, so a larger value has a wrong
// unit.
constexpr double kMaxDamping = 1e3;            // [N s/m]
constexpr double kMaxRotationalDamping = 1e2;  // [N m s/rad]
constexpr double kMaxLag = 0.1;                // [s]
constexpr double kMaxStiffness = 1e9;          // [N/m]
constexpr double kMaxMass = 1e3;               // [kg]
constexpr double kMaxForce = 1e4;              // [N]
constexpr double kMaxTorque = 1e3;             // [N m]
constexpr double kMaxResolution = 0.01;        // [m]
constexpr double kMaxInertia = 1e2;            // [kg m^2]
constexpr double kMaxSpeed = 1e3;              // [m/s]
constexpr double kMaxAngle = 0.1;              // [rad]
constexpr double kMaxExtent = 100.0;           // [m]
constexpr std::size_t kMaxName = 100;          // [bytes]

[[noreturn]] void refuse(const DeviceSpec& spec, const std::string& field, const std::string& why) {
  throw DeviceSpecError(spec.name.substr(0, kMaxName), field, why);
}

void check_range(const DeviceSpec& spec, const char* field, double value, double most,
                 const char* unit) {
  if (value >= 0.0 && value <= most) return;
  refuse(spec, field,
         "must be from 0 to " + std::to_string(most) + " " + unit + ", is " +
             std::to_string(value) + "; check the unit");
}

void check_damping(const DeviceSpec& spec, const char* field, const Damping& damping, double most,
                   const char* unit) {
  const Mat3& m = damping.matrix();
  for (int i = 0; i < 9; ++i)
    check_range(spec, field, i % 4 == 0 ? m(i / 3, i % 3) : std::abs(m(i / 3, i % 3)), most, unit);
  try {
    validate(damping, "the damping");
  } catch (const std::invalid_argument& error) {
    refuse(spec, field, error.what());
  }
}

}  // namespace

void validate(const DeviceSpec& spec) {
  if (spec.name.empty() || spec.name.size() > kMaxName)
    refuse(spec, "name", "must be 1 to " + std::to_string(kMaxName) + " bytes long");
  if (spec.translation_dof != 2 && spec.translation_dof != 3)
    refuse(spec, "translation_dof",
           "is " + std::to_string(spec.translation_dof) + "; only 2 (x, y) and 3 are supported");
  if (spec.rotation_sensed != 0 && spec.rotation_sensed != 3)
    refuse(spec, "rotation_sensed",
           "is " + std::to_string(spec.rotation_sensed) + "; only 0 and 3 are supported");
  if (spec.rotation_actuated != 0 && spec.rotation_actuated != 3)
    refuse(spec, "rotation_actuated",
           "is " + std::to_string(spec.rotation_actuated) + "; only 0 and 3 are supported");
  if (spec.rotation_actuated > spec.rotation_sensed)
    refuse(spec, "rotation_actuated",
           "is more than rotation_sensed: a torque that is not measured cannot be bounded; "
           "set rotation_actuated to 0");

  if (spec.actuation.late_ticks < 0 || spec.actuation.late_ticks > kMostLateTicks)
    refuse(spec, "late_ticks",
           "is " + std::to_string(spec.actuation.late_ticks) +
               "; give the ticks by which a force comes late, 0 to " +
               std::to_string(kMostLateTicks));

  check_range(spec, "actuation_lag", spec.actuation.lag, kMaxLag, "s");

  check_range(spec, "transmission_stiffness", spec.transmission.stiffness, kMaxStiffness, "N/m");
  check_damping(spec, "damping", spec.damping, kMaxDamping, "N s/m");
  check_damping(spec, "rotational_damping", spec.rotational_damping, kMaxRotationalDamping,
                "N m s/rad");
  check_range(spec, "apparent_mass", spec.apparent_mass, kMaxMass, "kg");
  check_range(spec, "coulomb_friction", spec.coulomb_friction, kMaxForce, "N");
  check_range(spec, "position_resolution", spec.position_resolution, kMaxResolution, "m");
  check_range(spec, "max_force", spec.max_force, kMaxForce, "N");
  check_range(spec, "continuous_force", spec.continuous_force, kMaxForce, "N");
  check_range(spec, "max_torque", spec.max_torque, kMaxTorque, "N m");
  check_range(spec, "workspace.x", spec.workspace.x(), kMaxExtent, "m");
  check_range(spec, "workspace.y", spec.workspace.y(), kMaxExtent, "m");
  check_range(spec, "workspace.z", spec.workspace.z(), kMaxExtent, "m");

  check_range(spec, "least_mass", spec.least_mass, kMaxMass, "kg");
  check_range(spec, "least_friction", spec.least_friction, kMaxForce, "N");
  check_range(spec, "hand_force", spec.hand_force, kMaxForce, "N");
  check_range(spec, "hand_speed", spec.hand_speed, kMaxSpeed, "m/s");
  check_range(spec, "rotational_resolution", spec.rotation.resolution, kMaxAngle, "rad");
  check_range(spec, "least_inertia", spec.rotation.least_inertia, kMaxInertia, "kg m^2");
  check_range(spec, "hand_torque", spec.rotation.hand_torque, kMaxTorque, "N m");
  check_range(spec, "apparent_inertia", spec.rotation.inertia, kMaxInertia, "kg m^2");
  check_range(spec, "rotational_friction", spec.rotation.friction, kMaxTorque, "N m");

  if (!(spec.max_force > 0.0)) refuse(spec, "max_force", "must be above zero [N]; give the peak");
  if (spec.continuous_force > spec.max_force)
    refuse(spec, "continuous_force", "must not exceed max_force; swap them or lower it");
  const auto below = [&](const char* field, double least, const char* typical, double value) {
    if (value > 0.0 && least > value)
      refuse(spec, field, std::string("must not exceed ") + typical + ", whose lower bound it is");
  };
  below("least_mass", spec.least_mass, "apparent_mass", spec.apparent_mass);
  below("least_friction", spec.least_friction, "coulomb_friction", spec.coulomb_friction);
  below("least_inertia", spec.rotation.least_inertia, "apparent_inertia", spec.rotation.inertia);
  if (!(spec.hand_force > 0.0))
    refuse(spec, "hand_force", "must be above zero [N]; 10 is more than most hands give");
  if ((spec.rotation.least_inertia > 0.0) != (spec.rotation.hand_torque > 0.0))
    refuse(spec, spec.rotation.least_inertia > 0.0 ? "hand_torque" : "least_inertia",
           "is not given: the account needs least_inertia and hand_torque together, or neither");
  if (spec.rotation_actuated == 0 && spec.max_torque > 0.0)
    refuse(spec, "max_torque", "must be 0 where rotation_actuated is 0; set either");
  if (spec.rotation_actuated > 0 && !(spec.max_torque > 0.0))
    refuse(spec, "max_torque", "must be above zero where rotation is actuated; give the peak");
}

Command actuated(const DeviceSpec& spec, Command command) noexcept {
  if (spec.translation_dof < 3) command.elastic.z() = command.frictional.z() = 0.0;
  if (spec.rotation_actuated == 0) command.torque.setZero();
  return command;
}

}  // namespace feltwire
