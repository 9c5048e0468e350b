#pragma once
// A serial port with reads and writes that do not wait.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// An exclusive raw serial port without flow control. No function allocates after opening.
class SerialPort {
 public:
  /// Throws std::runtime_error that names the error and the remedy.
  explicit SerialPort(const std::filesystem::path& port);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Returns how many bytes it took at once. Empty: the port is gone. Async-signal-safe.
  std::optional<std::size_t> write(std::span<const std::uint8_t> bytes) const noexcept;
  /// Returns how many bytes it read, as many as fit at most. Empty: as above.
  std::optional<std::size_t> read(std::span<std::uint8_t> room) const noexcept;
  /// Waits until bytes have come, the port is gone, or `latest` (a monotonic time). Returns whether
  /// read() has a result.
  bool wait(Nanoseconds latest) const noexcept;

 private:
  int descriptor_;
};

}  // namespace feltwire
