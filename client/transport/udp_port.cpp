#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "client/transport/datagram_port.hpp"
#include "protocol/net/udp_socket.hpp"

namespace feltwire {
namespace {

class UdpPort final : public DatagramPort {
 public:
  UdpPort(const Address& server, int dscp) : server_(server) {
    socket_ = ::socket(server_.storage.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || !forbid_fragments(socket_) || (dscp != 0 && !set_dscp(socket_, dscp)) ||
        !connect_socket(server_)) {
      const std::string reason = std::strerror(errno);
      if (socket_ >= 0) ::close(socket_);
      throw SessionError("cannot open a UDP socket to the scene: " + reason);
    }
  }
  ~UdpPort() override { ::close(socket_); }
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  bool connect(const Address& server) noexcept override {
    if (!connect_socket(server)) return false;
    server_ = server;
    return true;
  }

  bool reroute() noexcept override {
    ++statistics_.rerouted;
    // A socket keeps its local address until AF_UNSPEC dissolves the connection (connect(2)).
    const sockaddr dissolved{.sa_family = AF_UNSPEC, .sa_data = {}};
    return ::connect(socket_, &dissolved, sizeof dissolved) == 0 && connect_socket(server_);
  }

  void send(Bytes datagram) noexcept override {
    if (::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0) {
      ++statistics_.sent;
      return;
    }
    ++statistics_.send_failed;
    if (errno == EMSGSIZE) {
      ++statistics_.too_long;
      return;
    }
    // These errors are temporary. Other errors mean that the route is lost.
    const bool passes = errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS ||
                        errno == ECONNREFUSED || errno == EINTR;
    if (!passes) reroute();
  }

  std::optional<Bytes> receive() noexcept override {
    // recv() reports the error of an earlier datagram once: a closed server port or a too long
    // datagram. A signal may also interrupt it.
    for (int tries = 0; tries < kBurst; ++tries) {
      const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
      if (size >= 0) {
        ++statistics_.received;
        return Bytes(buffer_.data(), static_cast<std::size_t>(size));
      }
      if (errno == EAGAIN || errno == EWOULDBLOCK) break;
      if (errno == EMSGSIZE) ++statistics_.too_long;
    }
    return std::nullopt;
  }

  int descriptor() const noexcept override { return socket_; }
  PortStatistics statistics() const noexcept override { return statistics_; }

 private:
  /// Connects the socket. The socket then receives only the server's datagrams, and reports a
  /// closed port.
  bool connect_socket(const Address& server) noexcept {
    return ::connect(socket_, reinterpret_cast<const sockaddr*>(&server.storage), server.size) == 0;
  }

  int socket_ = -1;
  Address server_;
  std::array<std::uint8_t, kMaxDatagram + 1> buffer_;  // an extra byte reveals a too long datagram
  PortStatistics statistics_;
};

}  // namespace

std::unique_ptr<DatagramPort> open_udp_port(const Address& server, int dscp) {
  return std::make_unique<UdpPort>(server, dscp);
}

}  // namespace feltwire
