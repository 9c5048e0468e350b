#include "tests/devices/input_stand_in.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace stand_in {
namespace {

int fail(int error) {
  errno = error;
  return -1;
}

/// A bitmap in the kernel's format: machine words, truncated to the requested size.
class Bitmap {
 public:
  Bitmap(void* room, std::size_t size) : bytes_(static_cast<unsigned char*>(room)), size_(size) {
    std::memset(room, 0, size);
  }
  void set(unsigned code) {
    constexpr unsigned kPerWord = sizeof(unsigned long) * CHAR_BIT;
    const std::size_t place = code / kPerWord * sizeof(unsigned long);
    if (place + sizeof(unsigned long) > size_) return;
    unsigned long word = 0;
    std::memcpy(&word, bytes_ + place, sizeof word);
    word |= 1UL << (code % kPerWord);
    std::memcpy(bytes_ + place, &word, sizeof word);
  }
  int size() const { return static_cast<int>(size_); }

 private:
  unsigned char* bytes_;
  std::size_t size_;
};

int copy_bits(const std::set<unsigned>& codes, std::size_t size, void* room) {
  Bitmap bits(room, size);
  for (const unsigned code : codes) bits.set(code);
  return bits.size();
}

}  // namespace

InputDevice::InputDevice() = default;

InputDevice::~InputDevice() {
  if (device_ >= 0) ::close(device_);
}

int InputDevice::open() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw std::runtime_error("no socket pair");
  if (device_ >= 0) ::close(device_);
  device_ = ends[0];
  return ends[1];
}

int InputDevice::control(unsigned long request, void* room) {
  if (gone_) return fail(ENODEV);
  if (!is_event_node || _IOC_TYPE(request) != 'E') return fail(ENOTTY);
  const unsigned number = _IOC_NR(request);
  const std::size_t size = _IOC_SIZE(request);
  constexpr unsigned kVersion = 0x01, kKeyState = 0x18, kBits = 0x20, kAbs = 0x40, kGrab = 0x90;
  if (number == kVersion) {
    *static_cast<int*>(room) = EV_VERSION;
    return 0;
  }
  if (number == kGrab) {
    if (held_by_other) return fail(EBUSY);
    ++grabs;
    return 0;
  }
  if (number == kKeyState) return copy_bits(pressed, size, room);
  if (number == kBits + EV_KEY) return copy_bits(keys, size, room);
  if (number == kBits + EV_REL) return copy_bits(relative_axes, size, room);
  if (number == kBits + EV_ABS) {
    Bitmap bits(room, size);
    for (const auto& [code, axis] : axes) bits.set(code);
    return bits.size();
  }
  if (number >= kAbs && number < kAbs + ABS_CNT) {
    ++abs_asked;
    if (axes.empty()) return fail(EINVAL);
    input_absinfo info{};
    if (const auto found = axes.find(number - kAbs); found != axes.end()) {
      info.minimum = found->second.least;
      info.maximum = found->second.most;
      info.flat = found->second.flat;
      info.value = found->second.value;
    }
    std::memcpy(room, &info, std::min(size, sizeof info));
    return 0;
  }
  return fail(EINVAL);
}

void InputDevice::push(std::uint16_t type, unsigned code, int value) {
  input_event event{};
  event.type = type;
  event.code = static_cast<std::uint16_t>(code);
  event.value = value;
  buffer_.push_back(event);
  if (buffer_.size() == kBuffer) {
    input_event dropped{};
    dropped.type = EV_SYN;
    dropped.code = SYN_DROPPED;
    buffer_ = {dropped, event};
    whole_ = 0;
  }
  if (type == EV_SYN && code == SYN_REPORT) whole_ = buffer_.size();
}

/// An axis without movement makes no event.
void InputDevice::axis(unsigned code, int value) {
  if (std::exchange(axes.at(code).value, value) == value) return;
  anything_ = true;
  push(EV_ABS, code, value);
}

/// A relative movement of zero makes no event.
void InputDevice::relative(unsigned code, int value) {
  if (value == 0 || !relative_axes.contains(code)) return;
  anything_ = true;
  push(EV_REL, code, value);
}

void InputDevice::key(unsigned code, bool down) {
  if (!keys.contains(code) || pressed.contains(code) == down) return;
  if (down)
    pressed.insert(code);
  else
    pressed.erase(code);
  anything_ = true;
  push(EV_KEY, code, down ? 1 : 0);
}

/// An empty packet makes no event.
void InputDevice::report() {
  if (anything_) push(EV_SYN, SYN_REPORT, 0);
  anything_ = false;
}

void InputDevice::deliver() {
  for (; whole_ > 0; --whole_) {
    if (::send(device_, &buffer_.front(), sizeof(input_event), MSG_NOSIGNAL) < 0)
      throw std::runtime_error("the client's socket takes no more");
    buffer_.pop_front();
  }
}

void InputDevice::unplug() {
  gone_ = true;
  ::close(device_);
  device_ = -1;
}

void be_xpad(InputDevice& device) {
  for (const unsigned code : {ABS_X, ABS_Y, ABS_RX, ABS_RY})
    device.axes[code] = {-32768, 32767, 128, 0};
  for (const unsigned code : {ABS_Z, ABS_RZ}) device.axes[code] = {0, 255, 0, 0};
  for (const unsigned code : {ABS_HAT0X, ABS_HAT0Y}) device.axes[code] = {-1, 1, 0, 0};
  device.keys = {BTN_SOUTH, BTN_EAST, BTN_NORTH, BTN_WEST, BTN_TL, BTN_TR, BTN_SELECT, BTN_START};
}

void be_generic_pad(InputDevice& device) {
  for (const unsigned code : {ABS_X, ABS_Y, ABS_Z, ABS_RZ})
    device.axes[code] = {0, 65535, 4095, 32768};
  for (const unsigned code : {ABS_GAS, ABS_BRAKE}) device.axes[code] = {0, 1023, 63, 0};
  device.keys = {BTN_SOUTH, BTN_TL, BTN_TR};
}

void be_spacemouse(InputDevice& device) {
  for (unsigned code = ABS_X; code <= ABS_RZ; ++code) device.axes[code] = {-350, 350, 0, 0};
  device.keys = {BTN_0, BTN_1};
}

void be_relative_spacemouse(InputDevice& device) {
  for (unsigned code = REL_X; code <= REL_RZ; ++code) device.relative_axes.insert(code);
  device.keys = {BTN_0, BTN_1};
}

}  // namespace stand_in
