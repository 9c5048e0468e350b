// A substitute for libusb-1.0 with a Falcon at an FTDI converter: boot loader, firmware and legs.
// The source is published facts (Stamper's closed forms, the packets), not the driver.

#include <fcntl.h>
#include <sys/file.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "tests/devices/falcon_stand_in.hpp"
#include "tests/devices/scripted.hpp"
#include "tests/devices/shared_page.hpp"

namespace {

using stand_in::Three;
using Byte = std::uint8_t;

constexpr int kAccess = -3, kNoDevice = -4, kBusy = -6, kTimeout = -7;
constexpr double kTurn = 6.283185307179586;
int context_marker, handle_marker;
std::array<int, 4> device_markers;

std::unique_ptr<stand_in::Falcon> falcon = std::make_unique<stand_in::Falcon>();
std::mutex mutex;
std::deque<Byte> outgoing;  // bytes to the computer
unsigned baud = 0, latency = 16, modem = 0;
bool dtr_pulsed = false, loading = false, claimed = false;
std::vector<Byte> image, heard;
int opened_number = 0;     // number of the open Falcon
int claim_in_kernel = -1;  // file that locks the Falcon against other programs; -1: no lock
Three force{};             // [N] force on the mass

double leg_direction(int i) { return kTurn / 360.0 * std::array{105.0, -15.0, -135.0}[i]; }

/// Returns the angles [rad] of the upper arms for the position of the mass, from the tangent of the
/// half angle.
Three arms(const Three& mass) {
  constexpr double a = 0.060, b = 0.1025, c = 0.01443, d = 0.01125, e = d, f = -0.025, r = 0.0400,
                   s = -0.02309;
  const double x = mass[1], y = mass[2], z = mass[0] + 0.12;
  Three angles{};
  for (int i = 0; i < 3; ++i) {
    const double phi = leg_direction(i);
    const double u = std::cos(phi) * x + std::sin(phi) * y - r;
    const double v = -std::sin(phi) * x + std::cos(phi) * y - s;
    const double third = std::acos((v + f) / b);
    const double long_shin = d + e + b * std::sin(third);
    const double l0 = z * z + (u + c - a) * (u + c - a) - long_shin * long_shin;
    const double l1 = -4.0 * a * z;
    const double l2 = z * z + (u + c + a) * (u + c + a) - long_shin * long_shin;
    angles[i] = 2.0 * std::atan((-l1 - std::sqrt(l1 * l1 - 4.0 * l0 * l2)) / (2.0 * l2));
  }
  return angles;
}

/// Returns the force [N] for the motor counts, from the virtual work of small displacements.
Three force_of(const std::array<int, 3>& motors, const Three& at) {
  constexpr double kSmall = 1e-6;
  Three f{};
  for (int axis = 0; axis < 3; ++axis) {
    Three before = at, after = at;
    before[axis] -= kSmall;
    after[axis] += kSmall;
    const Three first = arms(before), last = arms(after);
    for (int i = 0; i < 3; ++i)
      f[axis] += motors[i] / -10000.0 * (last[i] - first[i]) / (2.0 * kSmall);
  }
  return f;
}

/// At most one program may claim the Falcon, as in the kernel. Returns false if another program has
/// it.
bool claim_from_others() {
  const char* const folder = std::getenv("FELTWIRE_STAND_IN_USB");
  if (folder == nullptr) return true;
  const std::string file = std::string(folder) + "/falcon-" + std::to_string(opened_number);
  claim_in_kernel = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  return ::flock(claim_in_kernel, LOCK_EX | LOCK_NB) == 0;
}

void say(const std::vector<Byte>& bytes) {
  outgoing.insert(outgoing.end(), bytes.begin(), bytes.end());
}

void boot(const Byte* bytes, std::size_t count) {
  const bool hello = count == 3 && bytes[0] == 0x0A && bytes[1] == 0x43 && bytes[2] == 0x0D;
  if (!hello || !dtr_pulsed || latency != 16) return;
  if (falcon->hello_misses > 0) {
    --falcon->hello_misses;
    say({0x00, 0x0D});
  } else {
    say({0x0A, 0x44, 0x2C, 0x0D});
  }
}

void load(const Byte* bytes, std::size_t count) {
  if (!loading) {
    loading = count == 1 && bytes[0] == 0x41;
    image.clear();
    if (loading) ++falcon->loads;
    say({static_cast<Byte>(falcon->refuses_load ? 0x3F : 0x41)});
    return;
  }
  std::vector<Byte> echo(bytes, bytes + count);
  image.insert(image.end(), bytes, bytes + count);
  if (image.size() > 1000 && falcon->wrong_echoes > 0) {
    --falcon->wrong_echoes;
    echo.back() ^= 1;
  }
  say(echo);
}

void answer() {
  std::array<int, 3> motors{};
  for (int i = 0; i < 3; ++i) {
    unsigned value = 0;
    for (int n = 0; n < 4; ++n)
      value |= static_cast<unsigned>(heard[1 + 4 * i + n] - 'A') << (4 * n);
    motors[i] = static_cast<std::int16_t>(value);
    falcon->largest_motor = std::max(falcon->largest_motor.load(), std::abs(motors[i]));
    if (falcon->homed != 7)
      falcon->motor_before_homing =
          std::max(falcon->motor_before_homing.load(), std::abs(motors[i]));
  }
  const unsigned extra = heard[13] - 'A';
  falcon->lights = static_cast<int>(extra & 0xEU);
  falcon->homing = (extra & 1U) != 0;
  ++falcon->requests;
  falcon->mass.advance(1e-3, force);
  const Three told = arms(falcon->mass.position);
  force = force_of(motors, falcon->mass.position);
  const double size = std::hypot(force[0], force[1], force[2]);
  if (stand_in::page() != nullptr) {
    stand_in::page()->tell(falcon->mass);
    stand_in::page()->force.store(size);
    falcon->buttons = static_cast<int>(stand_in::page()->buttons.load());
  }
  falcon->edge.tick();
  falcon->edge.command(size > 0.0);
  falcon->force = size;  // This store is last. A test that sees it may read the other values.
  const bool jumps = stand_in::takes_one(falcon->jumps);
  std::vector<Byte> reply(16, 'A');
  reply.front() = '<';
  reply.back() = '>';
  for (int i = 0; i < 3; ++i) {
    // An unhomed leg counts from its position at power-on.
    const int zero = (falcon->homed >> i & 1) != 0 ? 0 : 517 + i;
    long count = std::lround((told[i] * 360.0 / kTurn - 35.0) / (0.28125 * 14.25 / 110.0)) + zero;
    if (jumps && i == 1) count += 900;
    for (int n = 0; n < 4; ++n)
      reply[1 + 4 * i + n] =
          static_cast<Byte>('A' + (static_cast<unsigned long>(count) >> (4 * n) & 0xFU));
  }
  reply[13] = static_cast<Byte>('A' + (falcon->homed << 4 | (falcon->buttons & 0xF)));
  if (stand_in::takes_one(falcon->garbles)) reply[6] = 0x7E;
  if (stand_in::takes_one(falcon->wrong_ends)) reply.back() = 'A';
  if (stand_in::takes_one(falcon->late)) std::this_thread::sleep_for(std::chrono::milliseconds(30));
  say(reply);
  if (stand_in::takes_one(falcon->repeats)) say(reply);
}

void run_firmware(const Byte* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (bytes[i] == '<') heard.clear();
    heard.push_back(bytes[i]);
    if (heard.size() < 16 || heard.front() != '<') continue;
    if (heard.back() == '>' && !stand_in::takes_one(falcon->drops)) answer();
    heard.clear();
  }
}

}  // namespace

extern "C" {

stand_in::Falcon* stand_in_new() {
  const std::lock_guard lock(mutex);
  falcon = std::make_unique<stand_in::Falcon>();
  outgoing.clear();
  heard.clear();
  force = {};
  baud = 0, latency = 16, modem = 0;
  dtr_pulsed = loading = claimed = false;
  return falcon.get();
}

int libusb_init(void** context) {
  if (stand_in::page() != nullptr) falcon->devices = stand_in::page()->devices.load();
  return *context = &context_marker, 0;
}
void libusb_exit(void*) {}
ssize_t libusb_get_device_list(void*, void*** list) {
  static std::array<void*, 5> all;
  std::size_t count = 0;
  all[count++] = &device_markers[0];  // a mouse
  for (int i = 0; falcon->plugged && i < falcon->devices; ++i)
    all[count++] = &device_markers[1 + i];
  all[count] = nullptr;
  *list = all.data();
  return static_cast<ssize_t>(count);
}
void libusb_free_device_list(void**, int) {}
int libusb_get_device_descriptor(void* device, void* into) {
  struct {
    Byte length = 18, type = 1;
    std::uint16_t usb = 0x200;
    Byte of_class = 0, subclass = 0, protocol = 0, packet = 8;
    std::uint16_t vendor = 0x046D, product = 0xC077, device = 0x600;
    Byte texts[3] = {1, 2, 3}, configurations = 1;
  } about;
  if (device != &device_markers[0]) about.vendor = 0x0403, about.product = 0xCB48;
  std::memcpy(into, &about, 18);
  return 0;
}
int libusb_open(void* device, void** handle) {
  if (device == &device_markers[0]) return kNoDevice;
  if (!falcon->accessible) return kAccess;
  ++falcon->opened;
  opened_number = static_cast<int>(static_cast<int*>(device) - &device_markers[1]);
  stand_in::begin_for_page(falcon->mass, opened_number);
  *handle = &handle_marker;
  return 0;
}
void libusb_close(void* handle) {
  if (handle != &handle_marker || claimed) ++falcon->misuses;
  ++falcon->closed;
}
int libusb_claim_interface(void*, int number) {
  if (number != 0) ++falcon->misuses;
  if (falcon->busy || !claim_from_others()) return kBusy;
  claimed = true;
  return 0;
}
int libusb_release_interface(void*, int) {
  if (claim_in_kernel >= 0) ::close(claim_in_kernel);
  claim_in_kernel = -1;
  return claimed = false, 0;
}
int libusb_control_transfer(void*, Byte type, Byte what, std::uint16_t value, std::uint16_t index,
                            Byte*, std::uint16_t length, unsigned) {
  const std::lock_guard lock(mutex);
  if (falcon->unplug) return kNoDevice;
  if (type != 0x40 || index != 0 || length != 0 || !claimed) ++falcon->misuses;
  if (what == 0 && value == 1) outgoing.clear();
  if (what == 0 && value == 2) heard.clear();
  if (what == 1) {
    if ((value & 0x0100) != 0 && (value & 1) == 0) modem = 0;
    if (value == 0x0101) dtr_pulsed = modem == 0;
  }
  if (what == 3) {
    baud = value;
    if (value == 2 && loading) {
      loading = false;
      falcon->loaded = image == falcon->wanted;
    }
    if (value == 0x4138) loading = falcon->loaded = false;  // DTR resets the firmware.
  }
  if (what == 9) latency = value;
  return 0;
}
int libusb_bulk_transfer(void*, Byte endpoint, Byte* data, int length, int* transferred, unsigned) {
  *transferred = 0;
  while (falcon->blocks) std::this_thread::yield();
  if (falcon->unplug) return kNoDevice;
  std::unique_lock lock(mutex);
  if (!claimed) ++falcon->misuses;
  if (endpoint == 0x02) {
    const bool cut = baud == 2 && stand_in::takes_one(falcon->short_writes);
    const auto count = static_cast<std::size_t>(cut ? length / 2 : length);
    *transferred = static_cast<int>(count);
    if (baud == 0x4138) boot(data, count);
    if (baud == 0x15) load(data, count);
    if (baud == 2 && falcon->loaded) run_firmware(data, count);
    return cut ? kTimeout : 0;
  }
  if (endpoint != 0x81 || length < 64) ++falcon->misuses;
  if (outgoing.empty()) {  // After its latency, the converter sends only its two status bytes.
    lock.unlock();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    lock.lock();
  }
  const std::size_t most = falcon->in_pieces ? 5 : 62;
  const std::size_t count = std::min(most, outgoing.size());
  data[0] = 0x01, data[1] = 0x60;
  std::copy_n(outgoing.begin(), count, data + 2);
  outgoing.erase(outgoing.begin(), outgoing.begin() + static_cast<std::ptrdiff_t>(count));
  *transferred = static_cast<int>(count) + 2;
  return 0;
}
int libusb_set_auto_detach_kernel_driver(void*, int) { return 0; }
const void* libusb_get_version(void) {
  static const struct {
    std::uint16_t major = 1, minor = 0, micro = 26, nano = 11724;
    const char *rc = "", *description = "a stand-in";
  } version;
  return &version;
}
const char* libusb_error_name(int) { return "LIBUSB_ERROR"; }
}
