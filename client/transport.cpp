#include "client/transport.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "protocol/guard.hpp"

namespace feltwire {
namespace {

constexpr unsigned bit(DatagramKind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned kExpected = bit(DatagramKind::reply) | bit(DatagramKind::goodbye);

}  // namespace

Transport::Transport(const Address& server, std::uint64_t session, int redundancy, bool rotation,
                     std::unique_ptr<TwoWayLink> link)
    : session_(session),
      kept_(std::clamp(redundancy, 0, kMaxRedundancy) + 1),
      link_(std::move(link)) {
  socket_ = ::socket(server.storage.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  // Connected: only the server's datagrams are let in, and a closed port is noticed.
  if (socket_ < 0 ||
      ::connect(socket_, reinterpret_cast<const sockaddr*>(&server.storage), server.size) != 0) {
    const std::string reason = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    throw SessionError("cannot open a UDP socket to the scene: " + reason);
  }
  batch_.rotation = rotation;
  // The encoder takes its memory at the first and largest datagram of each kind: now, not in the
  // loop.
  SampleBatch largest;
  largest.rotation = rotation;
  largest.count = kept_;
  for (int i = 0; i < kept_; ++i)
    largest.samples[static_cast<std::size_t>(i)].index = static_cast<std::uint64_t>(kept_ - i);
  encoder_.samples(session_, 1, largest);
  encoder_.goodbye(session_, 1, GoodbyeReason::leaving);
}

Transport::~Transport() { ::close(socket_); }

bool Transport::resume(const SessionAddress& to) noexcept {
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to.server.storage), to.server.size) !=
      0)
    return false;
  session_ = to.session;
  packet_number_ = 0;
  seen_ = {};
  batch_.count = 0;  // the new session has not missed the samples of the old one
  return true;
}

void Transport::transmit(Bytes datagram) noexcept {
  if (::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0) {
    ++statistics_.sent;
  } else {
    ++statistics_.send_failed;
  }
}

void Transport::send(const Sample& sample) noexcept {
  auto& samples = batch_.samples;
  std::copy_backward(samples.begin(), samples.begin() + kept_ - 1, samples.begin() + kept_);
  samples.front() = sample;
  batch_.count = std::min(batch_.count + 1, kept_);
  const Bytes datagram = encoder_.samples(session_, ++packet_number_, batch_);
  if (!link_) return transmit(datagram);
  link_->up.enter(datagram, now_);
  transmit_due();
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
  // The refusal of an earlier datagram (the server's port is closed) comes back here, once; an
  // interruption likewise.
  for (int tries = 0; tries < kBurst; ++tries) {
    const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (size >= 0) {
      ++statistics_.received;
      return Bytes(buffer_.data(), static_cast<std::size_t>(size));
    }
    if (errno != ECONNREFUSED && errno != EINTR) break;
  }
  return std::nullopt;
}

Transport::Arrival Transport::receive(Reply& reply, GoodbyeReason& reason) noexcept {
  for (int tries = 0; tries < kBurst; ++tries) {
    const std::optional<Bytes> datagram = link_ ? link_->down.leave(now_) : take();
    if (!datagram) return Arrival::nothing;
    const Guarded guarded = guard(*datagram, kExpected);
    DropReason drop = guarded.drop;
    if (drop == DropReason::none && guarded.header.session != session_) drop = DropReason::session;
    if (drop == DropReason::none && !seen_.take(guarded.header.packet_number))
      drop = DropReason::packet_number;
    const bool is_reply = guarded.header.kind == DatagramKind::reply;
    if (drop == DropReason::none)
      drop = is_reply ? decode(guarded.payload, reply) : decode(guarded.payload, reason);
    if (drop == DropReason::none) return is_reply ? Arrival::reply : Arrival::goodbye;
    ++statistics_.dropped[static_cast<std::size_t>(drop)];
  }
  return Arrival::nothing;
}

void Transport::goodbye() noexcept {
  constexpr int kTimes = 3;
  for (int i = 0; i < kTimes; ++i)
    transmit(encoder_.goodbye(session_, ++packet_number_, GoodbyeReason::leaving));
}

}  // namespace feltwire
