#include "client/transport.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "protocol/udp_socket.hpp"

namespace feltwire {

Transport::Transport(const SessionAddress& to, const SessionParameters& parameters, bool rotation,
                     std::unique_ptr<TwoWayLink> link, const PositionScale& scale, int dscp)
    : server_(to.server),
      conversation_(to.session, to.keys, parameters, rotation, scale),
      link_(std::move(link)) {
  socket_ = ::socket(server_.storage.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  // Connected: only the server's datagrams are let in, and a closed port is noticed.
  if (socket_ < 0 || !forbid_fragments(socket_) || (dscp != 0 && !set_dscp(socket_, dscp)) ||
      !connect_to(server_)) {
    const std::string reason = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    throw SessionError("cannot open a UDP socket to the scene: " + reason);
  }
}

Transport::~Transport() { ::close(socket_); }

bool Transport::connect_to(const Address& server) noexcept {
  return ::connect(socket_, reinterpret_cast<const sockaddr*>(&server.storage), server.size) == 0;
}

bool Transport::resume(const SessionAddress& to) noexcept {
  if (!supported(to.keys.suite) || !connect_to(to.server)) return false;
  server_ = to.server;
  conversation_.resume(to.session, to.keys);
  return true;
}

bool Transport::reroute() noexcept {
  ++statistics_.rerouted;
  // A socket keeps the address of its first connection until it is dissolved (connect(2)).
  const sockaddr dissolved{.sa_family = AF_UNSPEC, .sa_data = {}};
  return ::connect(socket_, &dissolved, sizeof dissolved) == 0 && connect_to(server_);
}

void Transport::transmit(Bytes datagram) noexcept {
  if (::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0) {
    ++statistics_.sent;
    return;
  }
  ++statistics_.send_failed;
  if (errno == EMSGSIZE) return shorten();
  // These pass; any other says that there is no way from here.
  const bool passes = errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS ||
                      errno == ECONNREFUSED || errno == EINTR;
  if (!passes) reroute();
}

void Transport::shorten() noexcept {
  ++statistics_.too_long;
  conversation_.carry_fewer();
}

bool Transport::send(const Sample& sample) noexcept {
  const Bytes datagram = conversation_.pack(sample);
  if (datagram.empty()) return false;
  if (link_) {
    link_->up.enter(datagram, now_);
    transmit_due();
  } else {
    transmit(datagram);
  }
  return true;
}

void Transport::transmit_due() noexcept {
  while (const auto datagram = link_->up.leave(now_)) transmit(*datagram);
}

void Transport::pass(Nanoseconds now) noexcept {
  now_ = now;
  transmit_due();
  for (int i = 0; i < kBurst; ++i) {
    const auto datagram = take();
    if (!datagram) return;
    link_->down.enter(*datagram, now_);
  }
}

/// The next datagram that the socket has.
std::optional<Bytes> Transport::take() noexcept {
  // What became of an earlier datagram (the server's port is closed, it was too long on the way)
  // comes back here, once; an interruption likewise.
  for (int tries = 0; tries < kBurst; ++tries) {
    const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (size >= 0) {
      ++statistics_.received;
      return Bytes(buffer_.data(), static_cast<std::size_t>(size));
    }
    if (errno == EAGAIN || errno == EWOULDBLOCK) break;
    if (errno == EMSGSIZE) shorten();
  }
  return std::nullopt;
}

Transport::Arrival Transport::receive(Reply& reply, GoodbyeReason& reason) noexcept {
  for (int tries = 0; tries < kBurst; ++tries) {
    const std::optional<Bytes> datagram = link_ ? link_->down.leave(now_) : take();
    if (!datagram) return Arrival::nothing;
    switch (conversation_.take(*datagram, reply, reason)) {
      case Conversation::Arrival::reply:
        return Arrival::reply;
      case Conversation::Arrival::goodbye:
        return Arrival::goodbye;
      case Conversation::Arrival::dropped:
        break;
    }
  }
  return Arrival::nothing;
}

void Transport::goodbye() noexcept {
  constexpr int kTimes = 3;
  for (int i = 0; i < kTimes; ++i) transmit(conversation_.goodbye());
}

}  // namespace feltwire
