#pragma once
// A serial port that is read and written without waiting.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A serial port of one's own, raw, without flow control. Nothing here allocates after opening.
class SerialPort {
 public:
  /// Throws std::runtime_error that says what is wrong and the remedy.
  explicit SerialPort(const std::filesystem::path& port);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// How many bytes it took at once; none: it is not there any more. Async-signal-safe.
  std::optional<std::size_t> write(std::span<const std::uint8_t> bytes) const noexcept;
  /// How many bytes had come, at most as many as there is room for; none: as above.
  std::optional<std::size_t> read(std::span<std::uint8_t> room) const noexcept;
  /// Until something has come or the port is gone, or `latest` (a monotonic time). Whether
  /// read() has something to tell.
  bool wait(Nanoseconds latest) const noexcept;

 private:
  int descriptor_;
};

}  // namespace feltwire
