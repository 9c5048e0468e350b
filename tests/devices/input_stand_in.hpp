#pragma once
// An input device at an event node, from the kernel's documentation (input/event-codes,
// input/gamepad, and drivers/input/evdev.c for a client's buffer). A socket carries its events, and
// this class answers its ioctls. It knows nothing of feltwire.

#include <linux/input.h>

#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>

namespace stand_in {

class InputDevice {
 public:
  struct Axis {
    int least = 0, most = 0, flat = 0, value = 0;
  };

  InputDevice();
  ~InputDevice();
  InputDevice(const InputDevice&) = delete;
  InputDevice& operator=(const InputDevice&) = delete;

  /// The descriptor that open(2) of the node returns. Its receiver closes it.
  int open();
  /// The answer to ioctl(2) on it.
  int control(unsigned long request, void* room);

  // Actions of the user; a packet has all actions up to report().
  void axis(unsigned code, int value);
  void relative(unsigned code, int value);
  void key(unsigned code, bool pressed);
  void report();
  /// Makes the client's buffer readable up to the end of the last packet.
  void deliver();
  void unplug();

  std::map<unsigned, Axis> axes;  // of EV_ABS
  std::set<unsigned> relative_axes, keys;
  std::set<unsigned> pressed;
  bool held_by_other = false;  // another program has grabbed it
  bool is_event_node = true;
  int grabs = 0, abs_asked = 0;

 private:
  void push(std::uint16_t type, unsigned code, int value);

  static constexpr std::size_t kBuffer = 64;  // events in a client's buffer
  std::deque<input_event> buffer_;
  std::size_t whole_ = 0;  // events up to the end of the last packet
  bool anything_ = false;  // in the present packet
  bool gone_ = false;
  int device_ = -1;
};

/// A pad as the driver xpad shows it.
void be_xpad(InputDevice& device);
/// A pad under the generic HID driver: the right stick is Z and RZ, a trigger is GAS.
void be_generic_pad(InputDevice& device);
/// A 3D mouse whose axes have a range.
void be_spacemouse(InputDevice& device);
/// A 3D mouse with axes that the kernel regards as relative.
void be_relative_spacemouse(InputDevice& device);

}  // namespace stand_in
