#pragma once
// Blocking sockets to a server over IPv4 or IPv6: datagrams and the control connection.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <stdexcept>
#include <vector>

#include "protocol/wire/control.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/session_secrets.hpp"
#include "tests/support/tls.hpp"

namespace feltwire::test {

inline constexpr int kPatience =
    20'000;  // [ms] the longest wait of a test; a passing test never waits that long

/// A plain blocking socket to the server.
class RawSocket {
 public:
  /// Connects to `to` or the loopback address, from the address `from` of that family. `family` is
  /// AF_INET or AF_INET6.
  RawSocket(int type, std::uint16_t port, int family = AF_INET, const char* from = nullptr,
            const char* to = nullptr)
      : file_(::socket(family, type, 0)) {
    const auto with = [&](const char* address, std::uint16_t with_port, auto call) {
      sockaddr_in four{};
      four.sin_family = AF_INET;
      four.sin_port = htons(with_port);
      sockaddr_in6 six{};
      six.sin6_family = AF_INET6;
      six.sin6_port = htons(with_port);
      if (family == AF_INET)
        return ::inet_pton(AF_INET, address, &four.sin_addr) == 1 &&
               call(file_, reinterpret_cast<const sockaddr*>(&four), sizeof four) == 0;
      return ::inet_pton(AF_INET6, address, &six.sin6_addr) == 1 &&
             call(file_, reinterpret_cast<const sockaddr*>(&six), sizeof six) == 0;
    };
    if (from != nullptr && !with(from, 0, ::bind)) throw std::runtime_error("cannot bind");
    const char* loopback = family == AF_INET ? "127.0.0.1" : "::1";
    if (!with(to != nullptr ? to : loopback, port, ::connect))
      throw std::runtime_error("cannot connect");
  }
  ~RawSocket() { ::close(file_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  int descriptor() const { return file_; }

  void send(Bytes bytes) { ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  /// The next bytes, at most `most`; empty if the other side closed or nothing came.
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

/// The result of a join by a ControlClient.
struct JoinedBy {
  control::JoinAccepted accepted;
  std::uint16_t udp_port = 0;
  SessionKeys keys;
};

/// A client's control connection, admitted by a token (empty: it sends none).
class ControlClient {
 public:
  explicit ControlClient(std::uint16_t port, int family = AF_INET,
                         const Secret& token = admin_token().text, const char* from = nullptr)
      : port_(port),
        socket_(SOCK_STREAM, port, family, from),
        tls_(context_.get(), socket_.descriptor()) {
    const timeval patience{.tv_sec = kPatience / 1000, .tv_usec = 0};
    ::setsockopt(socket_.descriptor(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (!tls_.connect()) throw std::runtime_error("no TLS");
    if (!token.empty()) ask<control::Authenticated>(control::Authenticate{token});
  }

  int descriptor() const { return socket_.descriptor(); }
  TlsConnection& tls() { return tls_; }

  void send(const control::Message& message) { tls_.write(control::encode(message)); }
  void send_raw(Bytes bytes) { tls_.write(bytes); }

  std::optional<control::Message> receive() {
    const auto length = tls_.read(control::kFrameLengthSize);
    if (length.size() < control::kFrameLengthSize) return std::nullopt;
    const auto body = tls_.read(control::frame_length(
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
  JoinedBy join(const control::JoinRequest& request) {
    auto accepted = ask<control::JoinAccepted>(request);
    const SessionKeys keys = take_keys(accepted);
    return {accepted, static_cast<std::uint16_t>(port_ + accepted.port_offset), keys};
  }
  bool closed() { return tls_.read(1).empty(); }

 private:
  std::uint16_t port_;
  TlsContext context_ = client_context();
  RawSocket socket_;
  TlsConnection tls_;
};

}  // namespace feltwire::test
