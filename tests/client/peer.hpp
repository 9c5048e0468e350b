#pragma once
// The server side of a client's sockets, small enough to read in full: a UDP port of one scene and
// a control port.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstring>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "client/transport/control_client.hpp"
#include "client/transport/transport.hpp"
#include "protocol/session/protocol_versions.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/session_secrets.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/support/tls.hpp"

namespace feltwire::testing {

/// A socket on a port of 127.0.0.1: a free port, or one that a server has left. A receive gives up
/// after ten seconds, so a broken client fails a test and does not block it.
class LocalSocket {
 public:
  explicit LocalSocket(int type, std::uint16_t left = 0)
      : descriptor_(::socket(AF_INET, type | SOCK_CLOEXEC, 0)) {
    const int yes = left != 0 ? 1 : 0;
    ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_port = htons(left);
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof any;
    if (descriptor_ < 0 || ::bind(descriptor_, reinterpret_cast<sockaddr*>(&any), size) != 0 ||
        ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&any), &size) != 0)
      throw std::runtime_error("no local socket");
    std::memcpy(&address_.storage, &any, sizeof any);
    address_.size = sizeof any;
    port_ = ntohs(any.sin_port);
    limit(descriptor_);
  }
  ~LocalSocket() { ::close(descriptor_); }
  LocalSocket(const LocalSocket&) = delete;
  LocalSocket& operator=(const LocalSocket&) = delete;

  static void limit(int descriptor) {
    const timeval ten_seconds{.tv_sec = 10, .tv_usec = 0};
    ::setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &ten_seconds, sizeof ten_seconds);
  }
  int descriptor() const { return descriptor_; }
  std::uint16_t port() const { return port_; }
  const Address& address() const { return address_; }

 private:
  int descriptor_;
  std::uint16_t port_ = 0;
  Address address_;
};

/// A scene's port: receives the client's datagrams and sends the test's replies.
class ScenePeer {
 public:
  static constexpr std::uint64_t kSession = 0xfe17;

  const Address& address() const { return socket_.address(); }
  SessionAddress session() const { return {address(), kSession, test::keys(kSession)}; }

  /// The next datagram of any kind; empty if none came.
  std::vector<std::uint8_t> receive_bytes() {
    std::vector<std::uint8_t> bytes(2 * kMaxDatagram);
    client_.size = sizeof client_.storage;
    const ssize_t size = ::recvfrom(socket_.descriptor(), bytes.data(), bytes.size(), 0,
                                    reinterpret_cast<sockaddr*>(&client_.storage), &client_.size);
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }

  /// A datagram waits or comes within 10 ms.
  bool has_datagram() const {
    constexpr int kMilliseconds = 10;
    pollfd waiting{socket_.descriptor(), POLLIN, 0};
    return ::poll(&waiting, 1, kMilliseconds) == 1;
  }

  struct Received {
    DatagramKind kind = DatagramKind::reply;  // a kind that no client sends
    Header header;
    SampleBatch batch;
    GoodbyeReason reason = GoodbyeReason::evicted;
  };
  /// The next datagram, decoded as the server does.
  Received receive() {
    const std::vector<std::uint8_t> bytes = receive_bytes();
    const Guarded guarded = guard(bytes, 0b1010);
    Received received;
    EXPECT_EQ(guarded.drop, DropReason::none);
    if (guarded.drop != DropReason::none) return received;
    received.kind = guarded.header.kind;
    received.header = guarded.header;
    const auto payload = test::opened(bytes, test::Way::up);
    const DropReason drop = received.kind == DatagramKind::samples
                                ? decode(payload, received.batch)
                                : decode(payload, received.reason);
    EXPECT_EQ(drop, DropReason::none);
    return received;
  }

  void send_bytes(Bytes bytes) {
    EXPECT_EQ(::sendto(socket_.descriptor(), bytes.data(), bytes.size(), 0,
                       reinterpret_cast<const sockaddr*>(&client_.storage), client_.size),
              static_cast<ssize_t>(bytes.size()));
  }
  void send(const Reply& reply) { send_bytes(encoder_.reply(kSession, ++packet_number_, reply)); }
  void send(GoodbyeReason reason) {
    send_bytes(encoder_.goodbye(kSession, ++packet_number_, reason));
  }
  /// A reply to this sample with this command.
  static Reply reply_to(const Sample& sample, const Command& command = {}) {
    Reply reply;
    reply.sample_index = sample.index;
    reply.client_time = sample.client_time;
    reply.command = command;
    return reply;
  }
  test::SealedEncoder& encoder() { return encoder_; }

 private:
  LocalSocket socket_{SOCK_DGRAM};
  Address client_;
  test::SealedEncoder encoder_{test::Way::down};
  std::uint64_t packet_number_ = 0;
};

/// The answer with secrets for its session.
inline control::JoinAccepted with_secrets(control::JoinAccepted accepted) {
  put_keys(random_session_keys(accepted.suite), accepted);
  return accepted;
}

/// A control port that accepts any token, answers the first request with the given bytes and
/// closes. With no bytes it closes without an answer.
class ControlPeer {
 public:
  explicit ControlPeer(std::vector<std::uint8_t> answer, const ProtocolVersions& versions = {}) {
    ::listen(socket_.descriptor(), 1);
    thread_ =
        std::thread([this, answer = std::move(answer), versions] { serve(answer, versions); });
  }
  ~ControlPeer() {
    ::shutdown(socket_.descriptor(), SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
  }
  ControlPeer(const ControlPeer&) = delete;
  ControlPeer& operator=(const ControlPeer&) = delete;

  std::uint16_t port() const { return socket_.port(); }
  ServerAccess access() const { return test::access(port()); }
  /// The request of the client.
  const std::optional<control::Message>& request() {
    thread_.join();
    return request_;
  }
  /// The versions that the client says it speaks.
  ProtocolVersions greeted_by() {
    if (thread_.joinable()) thread_.join();
    return std::get<control::Authenticate>(greeting_.value()).versions;
  }
  /// The next message of a client; empty if it closed or sent none.
  static std::optional<control::Message> read(test::TlsConnection& tls) {
    const auto prefix = tls.read(control::kFrameLengthSize);
    if (prefix.size() < control::kFrameLengthSize) return std::nullopt;
    const std::uint32_t size = control::frame_length(
        std::span<const std::uint8_t, control::kFrameLengthSize>(prefix.data(), prefix.size()));
    return control::decode(tls.read(std::min<std::size_t>(size, control::kMaxFrame)));
  }

 private:
  void serve(const std::vector<std::uint8_t>& answer, const ProtocolVersions& versions) {
    const int connection = ::accept(socket_.descriptor(), nullptr, nullptr);
    if (connection < 0) return;
    LocalSocket::limit(connection);
    const test::TlsContext context = test::server_context(test::identity());
    {
      test::TlsConnection tls(context.get(), connection);
      if (tls.accept() && (greeting_ = read(tls))) {
        tls.write(control::encode(control::Authenticated{"tester", "*", Role::admin, versions}));
        request_ = read(tls);
        tls.write(answer);
      }
    }
    ::close(connection);
    ::shutdown(socket_.descriptor(), SHUT_RDWR);  // refuse later connections at once
  }

  LocalSocket socket_{SOCK_STREAM};
  std::optional<control::Message> greeting_, request_;
  std::thread thread_;
};

}  // namespace feltwire::testing
