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

/// Reads without waiting. Nothing here allocates after opening.
class EventNode {
 public:
  /// ioctl(2), or a stand-in's.
  using Control = std::function<int(int descriptor, unsigned long request, void* room)>;

  /// Takes the device for this program alone, so that no desktop moves its pointer with it. Throws
  /// std::runtime_error that says what is wrong and the remedy.
  explicit EventNode(const std::filesystem::path& node);
  /// Of a stand-in: `descriptor`, which it closes, does not block and brings whole input_events.
  EventNode(int descriptor, Control control);
  ~EventNode();
  EventNode(EventNode&& other) noexcept;
  EventNode& operator=(EventNode&&) = delete;

  /// How many events it read, as many as there is room for at most. None: it was unplugged.
  std::optional<std::size_t> read(std::span<input_event> room) const noexcept;

  // What the kernel knows of it. None, or empty: it does not say, as of one that was unplugged.
  std::optional<input_absinfo> axis(unsigned code) const noexcept;  // its range and its value now
  std::optional<InputKeys> pressed() const noexcept;                // that are held now
  InputKeys keys() const noexcept;                                  // that it has
  InputAxes axes() const noexcept;                                  // likewise, with a range
  InputAxes relative_axes() const noexcept;                         // likewise, without one

 private:
  void take();

  int descriptor_;
  Control control_;
};

}  // namespace feltwire
