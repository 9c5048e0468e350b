// A substitute for libHD with a simulated mass and its own scheduler. The source is the names,
// types, units and codes that users of OpenHaptics have published, not the driver.

#include "tests/devices/hd_stand_in.hpp"

#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include "tests/devices/shared_page.hpp"

namespace {

using stand_in::Three;
using Clock = std::chrono::steady_clock;
using Callback = unsigned(void*);

struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

constexpr unsigned kHandle = 3, kNone = 0xFFFFFFFFu;
constexpr double kTick = 1e-3, kMostTick = 1.25e-3;  // [s] tick of the mass, and longest tick
constexpr int kRamp = 500;                           // [ticks]

std::unique_ptr<stand_in::Hd> device = std::make_unique<stand_in::Hd>();
std::array<unsigned, 16> errors;
std::size_t error_count = 0;
Three force{}, wanted{};         // [N] force on the mass in our axes; requested force of this frame
Three before{};                  // [N] on the mass until the last frame ended
Three twist{};                   // [N m] of this frame
Clock::time_point began, ended;  // begin and end of the last frame
bool framed = false;             // true after the first frame
int ramp = 0;                    // remaining ticks
bool in_frame = false;

std::thread scheduler;
thread_local bool in_scheduler = false;
std::atomic<bool> runs{false};
std::atomic<Callback*> callback{nullptr};
void* user = nullptr;

void raise(unsigned code) {
  if (error_count < errors.size()) errors[error_count++] = code;
}
/// Moves the mass for the tick that ends. The former force acts until the last frame ended, and
/// then the new force.
void move() {
  const auto now = Clock::now();
  if (framed) {
    const double real = std::chrono::duration<double>(now - began).count();
    const double tick = device->virtual_time ? kTick : std::min(real, kMostTick);
    const double share = std::chrono::duration<double>(ended - began).count() / real;
    device->mass.advance(share * tick, before);
    device->mass.advance((1.0 - share) * tick, force);
  }
  began = now;
  framed = true;
}
bool allowed() { return !runs.load() || in_scheduler; }
void check(bool good) { device->misuses += good ? 0 : 1; }

void run() {
  in_scheduler = true;
  auto next = Clock::now();
  while (runs.load()) {
    if (!device->virtual_time) next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
    if (Clock::now() - next > std::chrono::milliseconds(5)) next = Clock::now();
    Callback* call = callback.load();
    if (call != nullptr && !device->stuck.load()) call(user);
  }
}

}  // namespace

extern "C" {

stand_in::Hd* stand_in_new() {
  device = std::make_unique<stand_in::Hd>();
  error_count = 0;
  force = wanted = before = twist = {};
  framed = false;
  ramp = 0;
  return device.get();
}

unsigned hdInitDevice(const char* name) {
  const bool found =
      device->plugged &&
      (std::strlen(device->known) == 0 ? name == nullptr
                                       : name != nullptr && std::strcmp(name, device->known) == 0);
  if (found) stand_in::begin_for_page(device->mass, 0);
  if (found) return ++device->opened, kHandle;
  raise(0x302);
  raise(0x300);
  return kNone;
}
void hdDisableDevice(unsigned) { ++device->closed; }
void hdMakeCurrentDevice(unsigned handle) { check(handle == kHandle); }
void hdBeginFrame(unsigned handle) {
  check(handle == kHandle && !in_frame && allowed());
  in_frame = true;
  move();
}
void hdEndFrame(unsigned) {
  check(in_frame && allowed());
  in_frame = false;
  while (device->blocks.load()) std::this_thread::yield();
  ended = Clock::now();
  before = force;
  if (const unsigned code = device->raises.exchange(0); code != 0) {
    raise(code);
    raise(code);
    ramp = kRamp;
  }
  if (const unsigned code = device->fails.load(); code != 0) {
    raise(code);
    ramp = kRamp;
  }
  const double size = std::hypot(wanted[0], wanted[1], wanted[2]);
  if (device->inkwell.load())
    device->asked_in_inkwell.store(std::max(device->asked_in_inkwell.load(), size));
  if (ramp > 0) device->asked_ramping.store(std::max(device->asked_ramping.load(), size));
  const double share = device->force_on ? 1.0 - static_cast<double>(ramp) / kRamp : 0.0;
  ramp = std::max(0, ramp - 1);
  force = {share * wanted[0], share * wanted[1], share * wanted[2]};
  device->torque = {share * twist[0], share * twist[1], share * twist[2]};
  const double turns = share * std::hypot(twist[0], twist[1], twist[2]);
  if (turns > device->largest_torque.load()) {
    device->largest_torque.store(turns);
    device->about_near.store(device->torque[0]);
  }
  device->edge.tick();
  device->edge.command(size > 0.0);
  ++device->frames;
  if (stand_in::page() != nullptr) {
    stand_in::page()->tell(device->mass);
    stand_in::page()->force.store(share * size);
    device->buttons.store(static_cast<int>(stand_in::page()->buttons.load()));
  }
  // This store is last. A test that sees it may read the other values.
  device->force.store(share * size);
}
ErrorInfo hdGetError() {
  if (error_count == 0) return {0, 0, 0};
  return {errors[--error_count], -1, kHandle};
}
const char* hdGetErrorString(unsigned code) {
  return code == 0x300 ? "HD_DEVICE_FAULT" : "HD_COMM_ERROR";
}
void hdEnable(unsigned what) {
  check(allowed());
  if (what == 0x4000) {
    device->force_on = true;
    ramp = kRamp;
  }
}
void hdDisable(unsigned what) {
  check(allowed());
  if (what == 0x4000) device->force_on = false;
}
void hdGetDoublev(unsigned what, double* values) {
  check(allowed());
  if (what == 0x2603) *values = 3.3;
  if (what != 0x2052) return;
  // The axes of the pen equal those of the device.
  for (int i = 0; i < 16; ++i) values[i] = i % 5 == 0 ? 1.0 : 0.0;
  const Three p = device->mass.sensed();
  device->told_near.store(p[0]);
  device->told_at.store(device->mass.time);
  // right, up, towards the user
  values[12] = 1e3 * p[1], values[13] = 1e3 * p[2], values[14] = 1e3 * p[0];
}
void hdGetIntegerv(unsigned what, int* value) {
  if (what == 0x2600) *value = 1000;
  if (what == 0x2000) *value = device->buttons.load();
  if (what == 0x2554) *value = device->output_dof;
}
void hdGetBooleanv(unsigned what, unsigned char* value) {
  check(allowed());
  if (what == 0x2002) *value = device->inkwell.load() ? 1 : 0;
}
const char* hdGetString(unsigned) { return device->model; }
void hdSetDoublev(unsigned what, const double* values) {
  const bool turns = what == 0x2701 && device->output_dof == 6;
  check((what == 0x2700 || turns) && in_frame);
  if (turns)  // [mN m]
    twist = {1e-3 * values[2], 1e-3 * values[0], 1e-3 * values[1]};
  else
    wanted = {values[2], values[0], values[1]};
}
unsigned hdCheckCalibration() { return device->calibration; }
unsigned hdCheckCalibrationStyle() { return device->style; }
void hdUpdateCalibration(unsigned) {
  ++device->updates;
  device->calibration = 0x5000;
}
unsigned long hdScheduleAsynchronous(Callback* call, void* with, unsigned short) {
  user = with;
  callback.store(call);
  return 1;
}
void hdUnschedule(unsigned long) { callback.store(nullptr); }
void hdStartScheduler() {
  runs.store(true);
  scheduler = std::thread(run);
}
void hdStopScheduler() {
  runs.store(false);
  if (scheduler.joinable()) scheduler.join();
}
}
