#include "client/conversation.hpp"

#include <algorithm>

#include "protocol/guard.hpp"

namespace feltwire {
namespace {

constexpr unsigned bit(DatagramKind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned kExpected = bit(DatagramKind::reply) | bit(DatagramKind::goodbye);

}  // namespace

Conversation::Conversation(std::uint64_t session, int redundancy, bool rotation)
    : session_(session), kept_(std::clamp(redundancy, 0, kMaxRedundancy) + 1), carried_(kept_) {
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

void Conversation::resume(std::uint64_t session) noexcept {
  session_ = session;
  packet_number_ = 0;
  seen_ = {};
  carried_ = kept_;
  batch_.count = 0;  // the new session has not missed the samples of the old one
}

Bytes Conversation::pack(const Sample& sample) noexcept {
  auto& samples = batch_.samples;
  std::copy_backward(samples.begin(), samples.begin() + kept_ - 1, samples.begin() + kept_);
  samples.front() = sample;
  batch_.count = std::min(batch_.count + 1, carried_);
  return encoder_.samples(session_, ++packet_number_, batch_);
}

bool Conversation::carry_fewer() noexcept {
  if (carried_ == 1) return false;
  --carried_;
  return true;
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
