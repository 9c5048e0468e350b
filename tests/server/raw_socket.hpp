#pragma once
// Plain blocking sockets to a server, over IPv4 or IPv6.

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <stdexcept>
#include <vector>

#include "protocol/control.hpp"
#include "protocol/datagram.hpp"
#include "protocol/placeholder_keys.hpp"

namespace feltwire::test {

inline constexpr int kPatience =
    20'000;  // [ms] how long a test waits before it gives up; never waited out

/// A plain blocking socket to the server.
class RawSocket {
 public:
  /// To this machine, `family` AF_INET or AF_INET6.
  RawSocket(int type, std::uint16_t port, int family = AF_INET) : file_(::socket(family, type, 0)) {
    sockaddr_in four{};
    four.sin_family = AF_INET;
    four.sin_port = htons(port);
    four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr_in6 six{};
    six.sin6_family = AF_INET6;
    six.sin6_port = htons(port);
    six.sin6_addr = in6addr_loopback;
    const bool is_four = family == AF_INET;
    const auto* address = is_four ? reinterpret_cast<const sockaddr*>(&four)
                                  : reinterpret_cast<const sockaddr*>(&six);
    if (::connect(file_, address, is_four ? sizeof four : sizeof six) != 0)
      throw std::runtime_error("cannot connect");
  }
  ~RawSocket() { ::close(file_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  int descriptor() const { return file_; }

  void send(Bytes bytes) { ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  /// What comes next, up to `most` bytes; empty when the other side closed or nothing came.
  std::vector<std::uint8_t> receive(std::size_t most = 2048) {
    pollfd waiting{file_, POLLIN, 0};
    if (::poll(&waiting, 1, kPatience) != 1) return {};
    std::vector<std::uint8_t> bytes(most);
    const auto size = ::recv(file_, bytes.data(), most, 0);
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }

 private:
  int file_;
};

/// The control connection of a client.
class ControlClient {
 public:
  explicit ControlClient(std::uint16_t port, int family = AF_INET)
      : socket_(SOCK_STREAM, port, family) {}

  int descriptor() const { return socket_.descriptor(); }

  void send(const control::Message& message) { socket_.send(control::encode(message)); }
  void send_raw(Bytes bytes) { socket_.send(bytes); }

  std::optional<control::Message> receive() {
    const auto length = exactly(control::kFrameLengthSize);
    if (length.empty()) return std::nullopt;
    const auto body = exactly(control::frame_length(
        std::span<const std::uint8_t, control::kFrameLengthSize>(length.data(), 4)));
    return control::decode(body);
  }
  template <class Answer>
  Answer ask(const control::Message& message) {
    send(message);
    const auto answer = receive();
    if (!answer || !std::holds_alternative<Answer>(*answer))
      throw std::runtime_error("another answer than expected");
    return std::get<Answer>(*answer);
  }
  /// Of a session that was joined here.
  static SessionKeys keys(const control::JoinAccepted& joined) {
    return placeholder_keys(joined.session);
  }
  bool closed() { return socket_.receive().empty(); }

 private:
  std::vector<std::uint8_t> exactly(std::size_t size) {
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < size) {
      const auto more = socket_.receive(size - bytes.size());
      if (more.empty()) return {};
      bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
  }
  RawSocket socket_;
};

}  // namespace feltwire::test
