#pragma once
// The maker's library of Force Dimension's devices: where it is, and the calls of it that are made.

#include <string>

#include "client/drivers/common/shared_library.hpp"

namespace feltwire::drd {

/// Throws std::runtime_error with the driver's name before the reason.
[[noreturn]] void refuse(const std::string& why);

/// Loads libdrd, or else libdhd. Throws std::runtime_error that names the searched places, or the
/// function that is missing.
SharedLibrary load();

/// The calls that are made, by the facts that others have published; the maker's header is not
/// here.
struct Calls {
  explicit Calls(const SharedLibrary& l)
      : version(l.get<void(int*, int*, int*, int*)>("dhdGetSDKVersion")),
        open(l.get<int(char)>("dhdOpenID")),
        close(l.get<int(char)>("dhdClose")),
        stop(l.get<int(char)>("dhdStop")),
        error(l.get<int()>("dhdErrorGetLast")),
        error_text(l.get<const char*()>("dhdErrorGetLastStr")),
        system_name(l.get<const char*(char)>("dhdGetSystemName")),
        has_wrist(l.get<bool(char)>("dhdHasWrist")),
        enable_force(l.get<int(unsigned char, char)>("dhdEnableForce")),
        brakes(l.get<int(int, char)>("dhdSetBrakes")),
        gravity(l.get<int(int, char)>("dhdSetGravityCompensation")),
        max_force(l.get<int(double, char)>("dhdSetMaxForce")),
        status(l.get<int(int*, char)>("dhdGetStatus")),
        position(l.get<int(double*, double*, double*, char)>("dhdGetPosition")),
        frame(l.get<int(double*, double*, double*, double (*)[3], char)>(
            "dhdGetPositionAndOrientationFrame")),
        set_force(l.get<int(double, double, double, char)>("dhdSetForce")),
        get_force(l.get<int(double*, double*, double*, char)>("dhdGetForce")),
        expert_on(l.find<int()>("dhdEnableExpertMode")),
        expert_off(l.find<int()>("dhdDisableExpertMode")),
        set_watchdog(l.find<int(unsigned char, char)>("dhdSetWatchdog")),
        get_watchdog(l.find<int(unsigned char*, char)>("dhdGetWatchdog")),
        initialized(l.find<bool(char)>("drdIsInitialized")),
        buttons(l.find<unsigned(char)>("dhdGetButtonMask")),
        has_active_wrist(l.find<bool(char)>("dhdHasActiveWrist")),
        max_torque(l.find<int(double, char)>("dhdSetMaxTorque")),
        set_wrench(l.find<SetWrench>("dhdSetForceAndTorqueAndGripperForce")),
        get_wrench(l.find<GetWrench>("dhdGetForceAndTorqueAndGripperForce")),
        has_gripper(l.find<bool(char)>("dhdHasGripper")),
        gripper_gap(l.find<int(double*, char)>("dhdGetGripperGap")),
        left_handed(l.find<bool(char)>("dhdIsLeftHanded")) {}

  // Force, torque and the gripper's force.
  using SetWrench = int(double, double, double, double, double, double, double, char);
  using GetWrench = int(double*, double*, double*, double*, double*, double*, double*, char);

  void (*version)(int*, int*, int*, int*);
  int (*open)(char);
  int (*close)(char);
  int (*stop)(char);
  int (*error)();
  const char* (*error_text)();
  const char* (*system_name)(char);
  bool (*has_wrist)(char);
  int (*enable_force)(unsigned char, char);
  int (*brakes)(int, char);
  int (*gravity)(int, char);
  int (*max_force)(double, char);
  int (*status)(int*, char);
  int (*position)(double*, double*, double*, char);
  int (*frame)(double*, double*, double*, double (*)[3], char);
  int (*set_force)(double, double, double, char);
  int (*get_force)(double*, double*, double*, char);
  // Not in every SDK; null where it is not.
  int (*expert_on)();
  int (*expert_off)();
  int (*set_watchdog)(unsigned char, char);
  int (*get_watchdog)(unsigned char*, char);
  bool (*initialized)(char);
  unsigned (*buttons)(char);
  bool (*has_active_wrist)(char);
  int (*max_torque)(double, char);
  SetWrench* set_wrench;
  GetWrench* get_wrench;
  bool (*has_gripper)(char);
  int (*gripper_gap)(double*, char);
  bool (*left_handed)(char);
};

}  // namespace feltwire::drd
