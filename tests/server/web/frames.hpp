#pragma once
// WebSocket frames as a client writes and reads them (RFC 6455, 5.2). Written from the RFC's text
// for the tests.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire::test {

struct Frame {
  int opcode = 0;  // 1 text, 2 binary, 8 close, 9 ping, 10 pong
  std::vector<std::uint8_t> payload;
  std::string text() const { return {payload.begin(), payload.end()}; }
  /// The code of a close frame.
  int code() const { return payload.size() < 2 ? 0 : payload[0] << 8 | payload[1]; }
  std::string reason() const { return payload.size() < 2 ? "" : text().substr(2); }
};

/// A masked frame of a client.
inline std::vector<std::uint8_t> client_frame(int opcode, std::string_view payload,
                                              bool last = true) {
  constexpr std::uint8_t kMask[4] = {0x12, 0x34, 0x56, 0x78};
  std::vector<std::uint8_t> bytes = {static_cast<std::uint8_t>((last ? 0x80 : 0) | opcode)};
  const std::size_t size = payload.size();
  if (size < 126) {
    bytes.push_back(static_cast<std::uint8_t>(0x80 | size));
  } else {
    bytes.insert(bytes.end(), {0xFE, static_cast<std::uint8_t>(size >> 8),
                               static_cast<std::uint8_t>(size & 0xFF)});
  }
  bytes.insert(bytes.end(), kMask, kMask + 4);
  for (std::size_t i = 0; i < size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(payload[i]) ^ kMask[i % 4]);
  return bytes;
}

/// Removes a whole server frame from the front; empty if it is not complete.
inline std::optional<Frame> take_frame(std::vector<std::uint8_t>& bytes) {
  if (bytes.size() < 2) return std::nullopt;
  std::size_t head = 2, size = bytes[1] & 0x7F;
  if (const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0; more > 0) {
    head += more;
    if (bytes.size() < head) return std::nullopt;
    size = 0;
    for (std::size_t i = 2; i < head; ++i) size = size << 8 | bytes[i];
  }
  if (bytes.size() < head + size) return std::nullopt;
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(head);
  const auto end = begin + static_cast<std::ptrdiff_t>(size);
  Frame frame{bytes[0] & 0x0F, {begin, end}};
  bytes.erase(bytes.begin(), end);
  return frame;
}

}  // namespace feltwire::test
