#include "client/conversation.hpp"

#include "protocol/guard.hpp"

namespace feltwire {
namespace {

constexpr unsigned bit(DatagramKind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned kExpected = bit(DatagramKind::reply) | bit(DatagramKind::goodbye);

}  // namespace

Conversation::Conversation(std::uint64_t session, const SessionParameters& parameters,
                           bool rotation, const PositionScale& scale)
    : session_(session), packer_(parameters, rotation, scale) {
  // The encoder takes its memory at the first and largest datagram of each kind: now, not in the
  // loop.
  SampleBatch largest;
  largest.rotation = rotation;
  largest.count = parameters.batch + parameters.redundancy;
  largest.previous = 1;
  for (int i = 0; i < largest.count; ++i)
    largest.samples[static_cast<std::size_t>(i)].index =
        static_cast<std::uint64_t>(largest.count - i) + 1;
  encoder_.samples(session_, 1, largest);
  encoder_.goodbye(session_, 1, GoodbyeReason::leaving);
}

void Conversation::resume(std::uint64_t session) noexcept {
  session_ = session;
  packet_number_ = 0;
  seen_ = {};
  packer_.restart();
}

Bytes Conversation::pack(const Sample& sample) noexcept {
  const SampleBatch* batch = packer_.add(sample);
  return batch == nullptr ? Bytes{} : encoder_.samples(session_, ++packet_number_, *batch);
}

Bytes Conversation::goodbye() noexcept {
  return encoder_.goodbye(session_, ++packet_number_, GoodbyeReason::leaving);
}

Conversation::Arrival Conversation::take(Bytes datagram, Reply& reply,
                                         GoodbyeReason& reason) noexcept {
  const Guarded guarded = guard(datagram, kExpected);
  DropReason drop = guarded.drop;
  if (drop == DropReason::none && guarded.header.session != session_) drop = DropReason::session;
  if (drop == DropReason::none && !seen_.take(guarded.header.packet_number))
    drop = DropReason::packet_number;
  const bool is_reply = guarded.header.kind == DatagramKind::reply;
  if (drop == DropReason::none)
    drop = is_reply ? decode(guarded.payload, reply) : decode(guarded.payload, reason);
  if (drop == DropReason::none) return is_reply ? Arrival::reply : Arrival::goodbye;
  ++dropped_[static_cast<std::size_t>(drop)];
  return Arrival::dropped;
}

}  // namespace feltwire
