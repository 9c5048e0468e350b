#include "tests/bench/net/echo.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire::netbench {
namespace {

constexpr std::size_t kBatch = 64;  // equal to the server's batch

/// A buffer for both directions.
struct Batch {
  std::array<std::array<std::uint8_t, kMaxDatagram>, kBatch> bytes;
  std::array<sockaddr_storage, kBatch> peers;
  std::array<iovec, kBatch> parts;
  std::array<mmsghdr, kBatch> messages;

  Batch() : bytes{}, peers{}, parts{}, messages{} {
    for (std::size_t i = 0; i < kBatch; ++i) {
      messages[i].msg_hdr = {.msg_name = &peers[i],
                             .msg_namelen = sizeof peers[i],
                             .msg_iov = &parts[i],
                             .msg_iovlen = 1,
                             .msg_control = nullptr,
                             .msg_controllen = 0,
                             .msg_flags = 0};
      parts[i] = {bytes[i].data(), kMaxDatagram};
    }
  }

  void echo(int socket, int count) {
    const auto size = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < size; ++i) parts[i].iov_len = messages[i].msg_len;
    ::sendmmsg(socket, messages.data(), static_cast<unsigned>(count), MSG_DONTWAIT);
    for (std::size_t i = 0; i < size; ++i) {
      parts[i].iov_len = kMaxDatagram;
      messages[i].msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    }
  }
};

}  // namespace

void echo(int socket, EchoKind kind) {
  static Batch batch;
  pollfd waiting{socket, POLLIN, 0};
  const int flags = kind == EchoKind::blocking ? MSG_WAITFORONE : MSG_DONTWAIT;
  while (true) {
    if (kind == EchoKind::waiting) ::poll(&waiting, 1, -1);
    const int received = ::recvmmsg(socket, batch.messages.data(), kBatch, flags, nullptr);
    if (received > 0) batch.echo(socket, received);
  }
}

}  // namespace feltwire::netbench
