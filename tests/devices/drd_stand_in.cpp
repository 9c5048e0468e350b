// A substitute for libdrd with a simulated mass. The source is the names, types and codes that
// users of Force Dimension have published, not the driver.

#include "tests/devices/drd_stand_in.hpp"

#include <memory>

#include "tests/devices/shared_page.hpp"

namespace {

using stand_in::Three;

std::unique_ptr<stand_in::Drd> device = std::make_unique<stand_in::Drd>();
Three force{}, torque{};  // [N], [N m]
char open_id = 0;
double quiet = 0.0;  // [s] time since the last command
int last_error = 0;
bool expert = false;

constexpr double kWatchdogUnit = 125e-6;  // [s]
constexpr int kFailed = -1, kTimeGuard = 1, kMotorSaturated = 2;
constexpr int kCommunication = 2, kNoDevice = 5, kExpertDisabled = 9;

bool between(long n, long from, long until) { return from >= 0 && n >= from && n < until; }

int failed(int error) {
  last_error = error;
  return kFailed;
}
bool answers(char id) {
  device->strangers += id == open_id ? 0 : 1;
  return id == open_id && device->plugged &&
         !between(device->readings, device->fails_from, device->fails_until);
}
bool forces_on() {
  return device->force_on && !device->watched_off &&
         !between(device->readings, device->off_from, device->off_until);
}

/// Sets force and torque. The motors limit the magnitude of force and torque, but not their
/// direction.
int set(double x, double y, double z, double about_x, double about_y, double about_z) {
  const double size = std::hypot(x, y, z), turns = std::hypot(about_x, about_y, about_z);
  const double share = size > device->saturates_at ? device->saturates_at / size : 1.0;
  const double part = turns > device->turns_at_most ? device->turns_at_most / turns : 1.0;
  force = {share * x, share * y, share * z};
  torque = {part * about_x, part * about_y, part * about_z};
  quiet = 0.0;
  if (size == 0.0 && turns == 0.0) ++device->zeros;
  if (stand_in::page() != nullptr) stand_in::page()->force.store(share * size);
  device->edge.command(size > 0.0 || turns > 0.0);
  // This store is last. A test that sees it may read the other values.
  device->pulls.store(size > 0.0 || turns > 0.0);
  return share < 1.0 || part < 1.0 ? kMotorSaturated : 0;
}

void let_go() {
  force = torque = {};
  device->edge.command(false);
  device->pulls.store(false);
  if (stand_in::page() != nullptr) stand_in::page()->force.store(0.0);
}

/// Advances the motion by a period and reads the encoders.
int sensed(double* x, double* y, double* z, char id) {
  while (device->blocks.load()) device->blocked.store(true);
  ++device->readings;
  device->edge.tick();
  quiet += device->period;
  if (device->watchdog > 0 && quiet > kWatchdogUnit * device->watchdog) {
    let_go();
    device->watched_off = true;
  }
  device->mass.advance(device->period, forces_on() ? force : Three{});
  device->wrist_mass.advance(device->period, forces_on() ? torque : Three{});
  device->most_made =
      std::max(device->most_made, device->mass.delivered - device->mass.burned +
                                      device->wrist_mass.delivered - device->wrist_mass.burned);
  if (stand_in::page() != nullptr) {
    stand_in::page()->tell(device->mass);
    device->buttons.store(stand_in::page()->buttons.load());
  }
  if (!answers(id)) return failed(kCommunication);
  static Three told;
  const bool old = device->stale_every > 0 && device->readings % device->stale_every == 0;
  if (!old) told = device->mass.sensed();
  *x = told[0], *y = told[1], *z = told[2];
  return old ? kTimeGuard : 0;
}

}  // namespace

extern "C" {

stand_in::Drd* stand_in_new() {
  device = std::make_unique<stand_in::Drd>();
  force = torque = {};
  quiet = 0.0;
  last_error = 0;
  return device.get();
}

void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = device->major, *minor = device->minor, *release = 5, *revision = 0;
}
int dhdOpenID(char index) {
  if (stand_in::page() != nullptr) device->devices = stand_in::page()->devices.load();
  if (!device->plugged || index >= device->devices) return failed(kNoDevice);
  ++device->opened;
  stand_in::begin_for_page(device->mass, index);
  return open_id = index;
}
int dhdClose(char) { return ++device->closed, 0; }
int dhdStop(char) {
  let_go();
  device->force_on = false;
  return ++device->stopped, 0;
}
int dhdErrorGetLast() { return last_error; }
const char* dhdErrorGetLastStr() { return last_error == kNoDevice ? "no device found" : "failed"; }
const char* dhdGetSystemName(char) { return device->system; }
bool dhdHasWrist(char) { return device->wrist; }
bool dhdHasActiveWrist(char) { return device->wrist && device->active_wrist; }
bool dhdHasGripper(char) { return device->gap >= 0.0; }
int dhdGetGripperGap(double* gap, char id) {
  if (!answers(id) || device->gap < 0.0) return failed(kCommunication);
  return *gap = device->gap, 0;
}
bool dhdIsLeftHanded(char) { return device->left_handed; }
bool drdIsInitialized(char) { return device->initialized; }
int dhdEnableForce(unsigned char on, char) {
  device->force_before_on = force != Three{} || torque != Three{};
  device->force_on = on != 0;
  device->watched_off = false;
  quiet = 0.0;
  return 0;
}
int dhdSetBrakes(int on, char) { return device->brakes_on = on != 0, 0; }
int dhdSetGravityCompensation(int on, char) {
  return device->gravity_on = on != 0 && device->gravity_works, 0;
}
int dhdSetMaxForce(double newtons, char) { return device->max_force = newtons, 0; }
int dhdSetMaxTorque(double most, char) { return device->max_torque = most, 0; }
int dhdGetStatus(int* status, char id) {
  if (!answers(id)) return failed(kCommunication);
  for (int i = 0; i < 17; ++i) status[i] = 0;
  status[0] = status[1] = status[2] = 1;
  status[5] = forces_on() ? 1 : 0;
  status[10] = device->gravity_on ? 1 : 0;
  if (!forces_on()) status[14] = device->watched_off ? 3 : device->off_cause;
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char id) { return sensed(x, y, z, id); }
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double (*m)[3], char id) {
  const int answer = sensed(x, y, z, id);
  // The wrist is rotated by a quarter turn about z. The tool's x axis is along the world's y axis.
  static double turn = 0.0;
  if (answer == 0) turn = device->active_wrist ? device->wrist_mass.sensed()[2] : 0.0;
  const double s = std::sin(turn), c = std::cos(turn);
  const double turned[3][3] = {{-s, -c, 0}, {c, -s, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m[i][j] = turned[i][j];
  return answer;
}
unsigned dhdGetButtonMask(char) { return device->buttons.load(); }
int dhdSetForce(double x, double y, double z, char id) {
  if (!answers(id)) return failed(kCommunication);
  return set(x, y, z, 0.0, 0.0, 0.0);
}
int dhdGetForce(double* x, double* y, double* z, char id) {
  if (!answers(id) || !device->tells_force) return failed(kCommunication);
  *x = force[0], *y = force[1], *z = force[2];
  return 0;
}
int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double about_x,
                                        double about_y, double about_z, double grip, char id) {
  if (!answers(id) || !device->active_wrist) return failed(kCommunication);
  device->grips = device->grips || grip != 0.0;
  return set(x, y, z, about_x, about_y, about_z);
}
int dhdGetForceAndTorqueAndGripperForce(double* x, double* y, double* z, double* about_x,
                                        double* about_y, double* about_z, double* grip, char id) {
  if (!answers(id) || !device->tells_force) return failed(kCommunication);
  *x = force[0], *y = force[1], *z = force[2];
  *about_x = torque[0], *about_y = torque[1], *about_z = torque[2], *grip = 0.0;
  return 0;
}
int dhdEnableExpertMode() { return expert = true, 0; }
int dhdDisableExpertMode() { return expert = false, 0; }
int dhdSetWatchdog(unsigned char units, char) {
  if (!expert || !device->watchdog_works) return failed(kExpertDisabled);
  return device->watchdog = units, 0;
}
int dhdGetWatchdog(unsigned char* units, char) { return *units = device->watchdog, 0; }
}
