// A plugin with a simulated mass and scripted faults. The plugin uses only feltwire_device_v1.h.

#include "tests/devices/plugin_stand_in.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

#include "client/drivers/plugin/feltwire_device_v1.h"
#include "tests/devices/shared_page.hpp"

namespace {

using stand_in::Three;

std::unique_ptr<stand_in::Plugin> device = std::make_unique<stand_in::Plugin>();
Three before, force;  // [N] force of the previous tick, and of the last tick
std::atomic<bool> released{false};
bool fresh = true;
double random_share = 0.5;

/// Any thread may release the device. Only the servo's thread changes the forces.
void drop_released() {
  if (released) before = force = {};
}

/// In a separate program the ticks follow the clock, because the server has no virtual time. The
/// plugin does not make up for a delay of more than a tick.
void pace() {
  using Clock = std::chrono::steady_clock;
  static Clock::time_point next = Clock::now();
  next = std::max(next + std::chrono::milliseconds(1), Clock::now());
  std::this_thread::sleep_until(next);
}

bool by_clock() { return stand_in::page() != nullptr && stand_in::page()->by_clock; }

/// With the clock, the mass moves under the present force up to now. A released force acted until
/// its release.
std::atomic<std::int64_t> released_at{0};  // [ns] steady clock
std::int64_t moved_to = 0;
std::int64_t clock_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
void advance_to(std::int64_t time) {
  constexpr double kNano = 1e-9;
  if (time > moved_to) device->mass.advance(kNano * static_cast<double>(time - moved_to), force);
  moved_to = std::max(moved_to, time);
}
void move_on() {
  const std::int64_t now = clock_now();
  if (moved_to == 0) moved_to = now;
  if (released) {
    advance_to(std::min(now, released_at.load()));
    before = force = {};
  }
  advance_to(now);
  stand_in::page()->tell_motion(device->mass);
}

/// Delays the reading while the hand moves.
void stall(int milliseconds) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(milliseconds);
  while (Clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    move_on();
  }
}

bool unplugged() {
  if (stand_in::page() != nullptr && stand_in::page()->unplugged) return true;
  return device->unplugged_at >= 0 && device->ticks >= device->unplugged_at;
}

void* open_device(const char* arguments, feltwire_spec_v1* spec, char* error, std::size_t size) {
  if (*device->open_error != '\0') {
    std::snprintf(error, size, "%s (%s)", device->open_error, arguments);
    return nullptr;
  }
  const stand_in::SimulatedMass& m = device->mass;
  std::strcpy(spec->name, "stand_in");
  spec->source = device->source;
  spec->translation_dof = 3;
  spec->longest_tick = device->period;
  for (double& b : spec->damping) b = m.damping;
  spec->apparent_mass = spec->least_mass = m.mass;
  spec->coulomb_friction = spec->least_friction = m.friction;
  spec->position_resolution = m.quantum;
  spec->max_force = 8.0;
  spec->late_ticks = device->late_ticks;
  if (device->turns) {
    spec->rotation_sensed = spec->rotation_actuated = 3;
    spec->rotational_damping = 1e-3;
    spec->rotational_resolution = 2e-4;
    spec->max_torque = 0.2;
  }
  for (double& w : spec->workspace) w = 0.2;
  released = false;
  moved_to = 0;
  before = force = {};
  stand_in::begin_for_page(device->mass, 0);
  return device.get();
}

int wait_for_tick(void*, std::int64_t) {
  if (unplugged()) return 0;
  if (stand_in::page() != nullptr) pace();
  if (by_clock()) move_on();
  drop_released();
  ++device->ticks;
  device->edge.tick();
  random_share = std::fmod(random_share * 997.13 + 0.317, 1.0);
  const double span = device->period - device->jitter * random_share;
  if (!by_clock()) {
    device->mass.advance(device->late * span, before);
    device->mass.advance((1.0 - device->late) * span, force);
  }
  if (stand_in::page() != nullptr) {
    stand_in::page()->tell(device->mass);
    device->buttons = stand_in::page()->buttons.load();
  }
  fresh = device->stale_every == 0 || device->ticks % device->stale_every != 0;
  return 1;
}

int read_device(void*, feltwire_reading_v1* reading) {
  while (device->blocks.load()) device->blocked.store(true);
  if (unplugged()) return FELTWIRE_FAULT;
  if (stand_in::page() != nullptr && stand_in::page()->slow_read > 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(stand_in::page()->slow_read));
  if (by_clock()) {
    stall(stand_in::page()->stall.exchange(0));
    move_on();
  }
  if (!fresh) {
    before = force;
    return FELTWIRE_STALE;
  }
  const Three p = device->mass.sensed();
  std::copy(p.begin(), p.end(), reading->position);
  reading->buttons = device->buttons;
  if (device->lever >= 0.0) {
    reading->has_lever = 1;
    reading->lever = device->lever;
  }
  if (device->late > 0.0 && device->tells_late) {
    reading->tells_held = 1;
    for (std::size_t i = 0; i < 3; ++i)
      reading->held_force[i] = device->late * before[i] + (1.0 - device->late) * force[i];
  }
  return FELTWIRE_OK;
}

int write_device(void*, const double* asked, const double* twist, double* held, double* turned) {
  if (stand_in::page() != nullptr && stand_in::page()->refuses) {
    force = {};
    stand_in::page()->force.store(0.0);
    return 1;
  }
  if (unplugged() || released) return 1;
  if (by_clock()) move_on();
  before = force;
  const double size = std::hypot(asked[0], asked[1], asked[2]);
  const double share = size > device->saturates_at ? device->saturates_at / size : 1.0;
  for (std::size_t i = 0; i < 3; ++i) held[i] = force[i] = share * asked[i];
  const double turn = std::hypot(twist[0], twist[1], twist[2]);
  const double part = turn > device->turns_at_most ? device->turns_at_most / turn : 1.0;
  for (std::size_t i = 0; i < 3; ++i) turned[i] = device->torque[i] = part * twist[i];
  device->edge.command(size > 0.0);
  if (stand_in::page() != nullptr) stand_in::page()->force.store(share * size);
  // This store is last. A test that sees it may read the other values.
  device->pulls.store(size > 0.0);
  return 0;
}

void release_device(void*) {
  if (!released) released_at = clock_now();
  released = true;
  device->edge.command(false);
  ++device->releases;
  if (stand_in::page() != nullptr) stand_in::page()->force.store(0.0);
  device->pulls.store(false);
}

void close_device(void*) {
  if (by_clock()) move_on();
  ++device->closes;
}

int lag_of_motors(void*, double* seconds, std::int32_t* kind) {
  if (device->lag < 0.0) return 0;
  *seconds = device->lag;
  *kind = device->lag_kind;
  return 1;
}

int transmission_of_handle(void*, double* stiffness, std::int32_t* encoder_side) {
  if (device->stiffness < 0.0) return 0;
  *stiffness = device->stiffness;
  *encoder_side = device->encoder_side;
  return 1;
}

}  // namespace

extern "C" {

stand_in::Plugin* stand_in_new() {
  device = std::make_unique<stand_in::Plugin>();
  return device.get();
}

const feltwire_device_v1* feltwire_device(void) {
  static feltwire_device_v1 table;
  table = {.version = device->version,
           .size = static_cast<std::uint32_t>(sizeof table - device->missing_bytes),
           .open = open_device,
           .wait = wait_for_tick,
           .read = read_device,
           .write = write_device,
           .release = release_device,
           .close = close_device,
           .actuation_lag = lag_of_motors,
           .transmission = transmission_of_handle};
  if (std::strcmp(device->null_function, "write") == 0) table.write = nullptr;
  if (std::strcmp(device->null_function, "wait") == 0) table.wait = nullptr;
  return &table;
}
}
