#pragma once
// The keys of the terminal that stop a device in an emergency, and start it again.

#include <termios.h>

#include <memory>
#include <optional>

#include "client/device/protected_device.hpp"

namespace feltwire {

/// While it exists, and the program is in the foreground of a terminal: the space bar presses the
/// emergency stop, `r` resets it. The terminal gives keys without Enter meanwhile and does not show
/// them; Ctrl-C works as ever.
class EmergencyKey {
 public:
  /// `stop` may be null: then no key is read. `keys`: the terminal's descriptor.
  EmergencyKey(std::shared_ptr<EmergencyStop> stop, int keys) noexcept;
  ~EmergencyKey();
  EmergencyKey(const EmergencyKey&) = delete;
  EmergencyKey& operator=(const EmergencyKey&) = delete;

  /// To wait for keys by poll(); -1: none come.
  int descriptor() const noexcept { return before_ ? keys_ : -1; }
  enum class Turned : std::uint8_t { nothing, stopped, started };
  /// Obeys the keys that have come. Call it where poll() says that the descriptor is ready.
  /// Pressing wins over resetting in the same call.
  Turned take() noexcept;

 private:
  std::shared_ptr<EmergencyStop> stop_;
  int keys_;
  std::optional<termios> before_;
};

}  // namespace feltwire
