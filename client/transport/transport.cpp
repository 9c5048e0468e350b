#include "client/transport/transport.hpp"

#include <utility>

namespace feltwire {

Transport::Transport(const SessionAddress& to, const SessionParameters& parameters, bool rotation,
                     std::unique_ptr<DatagramPort> port, const PositionScale& scale)
    : datagrams_(to.session, to.keys, parameters, rotation, scale),
      port_(port != nullptr ? std::move(port) : open_udp_port(to.server)) {}

bool Transport::resume(const SessionAddress& to) noexcept {
  look_at_lengths();
  if (!supported(to.keys.suite) || !port_->connect(to.server)) return false;
  datagrams_.resume(to.session, to.keys);
  return true;
}

/// Reduces the samples per datagram if a datagram was too long for the path.
void Transport::look_at_lengths() noexcept {
  for (const std::uint64_t seen = port_->statistics().too_long; too_long_ < seen; ++too_long_)
    datagrams_.carry_fewer();
}

bool Transport::send(const Sample& sample, const std::optional<HandReport>& report,
                     const std::optional<Lead>& lead) noexcept {
  look_at_lengths();
  const Bytes datagram = datagrams_.pack(sample, report, lead);
  if (datagram.empty()) return false;
  port_->send(datagram);
  return true;
}

Transport::Arrival Transport::receive(Reply& reply, GoodbyeReason& reason, int& left) noexcept {
  while (left > 0) {
    const std::optional<Bytes> datagram = port_->receive();
    if (!datagram) return Arrival::nothing;
    --left;
    switch (datagrams_.take(*datagram, reply, reason)) {
      case DatagramSession::Arrival::reply:
        return Arrival::reply;
      case DatagramSession::Arrival::goodbye:
        return Arrival::goodbye;
      case DatagramSession::Arrival::dropped:
        break;
    }
  }
  return Arrival::nothing;
}

void Transport::goodbye() noexcept {
  constexpr int kTimes = 3;
  for (int i = 0; i < kTimes; ++i) port_->send_now(datagrams_.goodbye());
}

}  // namespace feltwire
