#pragma once
// Garbage for a scene's port, as fast as one thread can send it.

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <vector>

#include "tests/bench/net/machine.hpp"

namespace feltwire::netbench {

/// Garbage made in advance (tests/support/garbage.hpp), so that only sending takes time.
class Flood {
 public:
  /// `sessions`: the sessions that the attacker knows.
  Flood(std::uint16_t port, const std::vector<std::uint64_t>& sessions);
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  /// Sends one burst.
  void burst() noexcept;
  std::uint64_t sent() const { return sent_; }

 private:
  static constexpr std::size_t kBurst = 16, kDatagrams = 256;
  Socket socket_;
  std::vector<std::vector<std::uint8_t>> datagrams_;
  std::array<iovec, kDatagrams> parts_{};
  std::array<mmsghdr, kDatagrams> messages_{};
  std::size_t next_ = 0;
  std::uint64_t sent_ = 0;
};

}  // namespace feltwire::netbench
