#pragma once
// An input device (a gamepad, a 3D mouse) at its event node, /dev/input/eventN: the kernel's
// interface evdev (linux/input.h).

#include <linux/input.h>

#include <bitset>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>

namespace feltwire {

using InputKeys = std::bitset<KEY_CNT>;
using InputAxes = std::bitset<ABS_CNT>;

/// Reads events without waiting. No function allocates after opening.
class EventNode {
 public:
  /// The type of ioctl(2). Tests give another function.
  using Control = std::function<int(int descriptor, unsigned long request, void* room)>;

  /// Opens the node and grabs the device, so that no desktop moves its pointer with it. Throws
  /// std::runtime_error that names the error and the remedy.
  explicit EventNode(const std::filesystem::path& node);
  /// For tests: takes ownership of `descriptor`, which does not block and delivers whole
  /// input_events.
  EventNode(int descriptor, Control control);
  ~EventNode();
  EventNode(EventNode&& other) noexcept;
  EventNode& operator=(EventNode&&) = delete;

  /// Reads as many events as fit, and returns their number. Empty: the device was unplugged.
  std::optional<std::size_t> read(std::span<input_event> room) const noexcept;

  // The kernel's data of the device. Empty if the kernel does not answer, as after unplugging.
  std::optional<input_absinfo> axis(
      unsigned code) const noexcept;                  // range and present value of an axis
  std::optional<InputKeys> pressed() const noexcept;  // the keys that are pressed now
  InputKeys keys() const noexcept;                    // the keys that the device has
  InputAxes axes() const noexcept;                    // the absolute axes that it has
  InputAxes relative_axes() const noexcept;           // the relative axes that it has

 private:
  void take();

  int descriptor_;
  Control control_;
};

}  // namespace feltwire
