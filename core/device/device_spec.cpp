#include "core/device/device_spec.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

#include "core/base/choice.hpp"

namespace feltwire {
namespace {

// Sources, cited below by their letter.
// [S] the simulated device of docs/bounding.md: the parameters its tables were measured with.
// [D] the maker's data sheet as repeated by others (tables of haptic devices in public notes); the
//     sheet itself was not at hand.
// [C] CHAI3D's device classes (cPhantomDevice, cDeltaDevice): the specification they state.
// [P] Kim, Kim, Seo, Ryu, "Directionally Transparent Energy Bounding Approach ...": a commercial
//     2-dof device, the ImpulseEngine 2000, and "the 3-dof PHANToM"; no other numbers.
// assumption: no source found. The account lets the hand have what the device is sure to have
//     burned, so a damping that is assumed is small on purpose: too small costs little stiffness,
//     too large makes energy. Measure that of your own device (docs/devices.md).

const std::array<DeviceSpec, 5>& devices() {
  static const std::array<DeviceSpec, 5> list = {{
      {.name = "simulated",
       .translation_dof = 3,          // [S]
       .rotation_sensed = 0,          // [S]
       .rotation_actuated = 0,        // [S]
       .damping = 0.5,                // [S]
       .rotational_damping = 0.0,     // no rotation
       .apparent_mass = 0.05,         // [S]
       .coulomb_friction = 0.1,       // [S]
       .position_resolution = 23e-6,  // [S]
       .max_force = 8.9,  // the ImpulseEngine 2000's, assumption below: [S] does not say, and
                          // this gives its figures (docs/lab/figures.md)
       .continuous_force = 8.9,       // assumption: a simulated motor does not heat up
       .max_torque = 0.0,             // no rotation
       .workspace = {0.4, 0.4, 0.4},  // assumption: the room of scenes/room.json
       .least_mass = 0.05,            // [S]
       .least_friction = 0.075,       // three quarters of [S]
       .hand_force = 10.0},           // assumption: fingers that press and pull
      {.name = "impulse_engine_2000",
       .translation_dof = 2,              // [P]
       .rotation_sensed = 0,              // [P]
       .rotation_actuated = 0,            // [P]
       .damping = 0.05,                   // assumption, small on purpose
       .rotational_damping = 0.0,         // no rotation
       .apparent_mass = 0.05,             // assumption: as simulated
       .coulomb_friction = 0.1,           // assumption: as simulated
       .position_resolution = 20e-6,      // assumption
       .max_force = 8.9,                  // assumption (2 lbf)
       .continuous_force = 8.9,           // assumption
       .max_torque = 0.0,                 // no rotation
       .workspace = {0.152, 0.152, 0.0},  // assumption (6 in by 6 in)
       .least_mass = 0.0375,              // assumption: a good deal below the apparent mass
       .least_friction = 0.05,            // assumption: half of the usual
       .hand_force = 10.0},               // assumption: fingers that press and pull
      {.name = "phantom_premium_1.5",
       .translation_dof = 3,          // [P]
       .rotation_sensed = 0,          // [P] the 3-dof version
       .rotation_actuated = 0,        // [P]
       .damping = 0.005,              // assumption, small on purpose: a light cable drive
       .rotational_damping = 0.0,     // no rotation
       .apparent_mass = 0.075,        // assumption: the figure usually quoted, source not found
       .coulomb_friction = 0.04,      // assumption: likewise (backdrive friction)
       .position_resolution = 30e-6,  // [D]
       .max_force = 8.5,         // [D]; [C] 8.5 for the 6-dof version, 4.0 in an earlier release
       .continuous_force = 1.4,  // [D]
       .max_torque = 0.0,        // no rotation
       .workspace = {0.381, 0.267, 0.191},  // [D]
       .least_mass = 0.05,                  // assumption: a good deal below the apparent mass
       .least_friction = 0.02,              // assumption: half of the usual
       .hand_force = 10.0},                 // assumption: fingers that press and pull
      {.name = "touch",
       .translation_dof = 3,          // [D] [C]
       .rotation_sensed = 3,          // [D] [C]
       .rotation_actuated = 0,        // [D] [C]
       .damping = 0.05,               // assumption, small on purpose
       .rotational_damping = 0.0,     // not actuated: no torque to bound
       .apparent_mass = 0.045,        // assumption: the figure usually quoted, source not found
       .coulomb_friction = 0.26,      // assumption: likewise (backdrive friction)
       .position_resolution = 55e-6,  // [D]
       .max_force = 3.3,              // [D] [C]
       .continuous_force = 0.88,      // [D]
       .max_torque = 0.0,             // not actuated
       .workspace = {0.160, 0.120, 0.070},  // [D]
       .least_mass = 0.03,                  // assumption: a good deal below the apparent mass
       .least_friction = 0.13,              // assumption: half of the usual
       .hand_force = 10.0},                 // assumption: fingers that press and pull
      {.name = "omega.7",
       .translation_dof = 3,          // [C]
       .rotation_sensed = 3,          // [C]
       .rotation_actuated = 0,        // [C] (the gripper is no part of this)
       .damping = 0.05,               // assumption, small on purpose
       .rotational_damping = 0.0,     // not actuated: no torque to bound
       .apparent_mass = 0.25,         // assumption
       .coulomb_friction = 0.2,       // assumption
       .position_resolution = 10e-6,  // assumption: the figure usually quoted, source not found
       .max_force = 12.0,             // [C]
       .continuous_force = 12.0,      // assumption: [C] gives one figure only
       .max_torque = 0.0,             // not actuated
       .workspace = {0.110, 0.160, 0.160},  // assumption: a disc of 160 mm, 110 mm deep along x
       .least_mass = 0.15,                  // assumption: a good deal below the apparent mass
       .least_friction = 0.1,               // assumption: half of the usual
       .hand_force = 10.0},                 // assumption: fingers that press and pull
  }};
  return list;
}

// Ceilings that no haptic device reaches; beyond them a unit has been mistaken.
constexpr double kMaxDamping = 1e3;            // [N s/m]
constexpr double kMaxRotationalDamping = 1e2;  // [N m s/rad]
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
  check_range(spec, "rotational_resolution", spec.rotational_resolution, kMaxAngle, "rad");
  check_range(spec, "least_inertia", spec.least_inertia, kMaxInertia, "kg m^2");
  check_range(spec, "hand_torque", spec.hand_torque, kMaxTorque, "N m");

  if (!(spec.max_force > 0.0)) refuse(spec, "max_force", "must be above zero [N]; give the peak");
  if (spec.continuous_force > spec.max_force)
    refuse(spec, "continuous_force", "must not exceed max_force; swap them or lower it");
  const auto below = [&](const char* field, double least, const char* typical, double value) {
    if (value > 0.0 && least > value)
      refuse(spec, field, std::string("must not exceed ") + typical + ", whose lower bound it is");
  };
  below("least_mass", spec.least_mass, "apparent_mass", spec.apparent_mass);
  below("least_friction", spec.least_friction, "coulomb_friction", spec.coulomb_friction);
  if (!(spec.hand_force > 0.0))
    refuse(spec, "hand_force", "must be above zero [N]; 10 is more than most hands give");
  if ((spec.least_inertia > 0.0) != (spec.hand_torque > 0.0))
    refuse(spec, spec.least_inertia > 0.0 ? "hand_torque" : "least_inertia",
           "is not given: the account needs least_inertia and hand_torque together, or neither");
  if (spec.rotation_actuated == 0 && spec.max_torque > 0.0)
    refuse(spec, "max_torque", "must be 0 where rotation_actuated is 0; set either");
  if (spec.rotation_actuated > 0 && !(spec.max_torque > 0.0))
    refuse(spec, "max_torque", "must be above zero where rotation is actuated; give the peak");
}

std::span<const DeviceSpec> builtin_devices() { return devices(); }

const DeviceSpec& builtin_device(std::string_view name) {
  return chosen("device", name, devices(), &DeviceSpec::name);
}

Command actuated(const DeviceSpec& spec, Command command) noexcept {
  if (spec.translation_dof < 3) command.elastic.z() = command.frictional.z() = 0.0;
  if (spec.rotation_actuated == 0) command.torque.setZero();
  return command;
}

}  // namespace feltwire
