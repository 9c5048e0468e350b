#pragma once
// An input device at an event node, as the kernel's documentation describes it (input/event-codes,
// input/gamepad, and drivers/input/evdev.c for the buffer of a client). Its events come through a
// socket, its ioctls are answered here. It knows nothing of feltwire.

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

  /// The descriptor that open(2) of the node gives. Whoever takes it closes it.
  int open();
  /// What ioctl(2) does with it.
  int control(unsigned long request, void* room);

  // What the person does; a packet is what happens until report().
  void axis(unsigned code, int value);
  void relative(unsigned code, int value);
  void key(unsigned code, bool pressed);
  void report();
  /// Lets the client read what its buffer has, up to the end of the last packet.
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

  static constexpr std::size_t kBuffer = 64;  // events of a client
  std::deque<input_event> buffer_;
  std::size_t whole_ = 0;  // events up to the end of the last packet
  bool anything_ = false;  // in the packet that is being made
  bool gone_ = false;
  int device_ = -1;
};

/// A pad as the driver xpad shows it.
void be_xpad(InputDevice& device);
/// A pad of the generic HID driver: the right stick at Z and RZ, a trigger at GAS.
void be_generic_pad(InputDevice& device);
/// A 3D mouse whose axes have a range.
void be_spacemouse(InputDevice& device);
/// A 3D mouse whose axes the kernel takes for relative ones.
void be_relative_spacemouse(InputDevice& device);

}  // namespace stand_in
