#include "client/transport/datagram_session.hpp"

#include <algorithm>

namespace feltwire {
namespace {

constexpr unsigned kForDevices = set_of({DatagramKind::reply, DatagramKind::goodbye});

}  // namespace

DatagramSession::DatagramSession(std::uint64_t session, const SessionKeys& keys,
                                 const SessionParameters& parameters, bool rotation,
                                 const PositionScale& scale)
    : session_(session),
      packer_(parameters, rotation, scale),
      sealer_(keys.suite, keys.up),
      opener_(keys.suite, keys.down) {
  // The encoder allocates memory for the largest datagram of each kind. Encode these datagrams
  // here, before the loop.
  SampleBatch largest;
  largest.rotation = rotation;
  largest.count = parameters.batch + parameters.redundancy;
  largest.previous = 1;
  largest.report = HandReport{.times = HandTimes{}};
  largest.lead = Lead{};
  for (int i = 0; i < largest.count; ++i)
    largest.samples[static_cast<std::size_t>(i)].index =
        static_cast<std::uint64_t>(largest.count - i) + 1;
  encoder_.samples(largest);
  encoder_.goodbye(GoodbyeReason::leaving);
}

void DatagramSession::resume(std::uint64_t session, const SessionKeys& keys) noexcept {
  session_ = session;
  sealer_ = Sealer(keys.suite, keys.up);
  opener_ = Opener(keys.suite, keys.down);
  packer_.restart();
  paced_by_ = 0;
}

Bytes DatagramSession::pack(const Sample& sample, const std::optional<HandReport>& report,
                            const std::optional<Lead>& lead) noexcept {
  const SampleBatch* batch = packer_.add(sample, report, lead);
  if (batch == nullptr) return {};
  return sealer_.seal(DatagramKind::samples, session_, encoder_.samples(*batch), sealed_);
}

Bytes DatagramSession::goodbye() noexcept {
  return sealer_.seal(DatagramKind::goodbye, session_, encoder_.goodbye(GoodbyeReason::leaving),
                      sealed_);
}

DatagramSession::Arrival DatagramSession::take(Bytes datagram, Reply& reply,
                                               GoodbyeReason& reason) noexcept {
  const Received got = receive(datagram, kForDevices, session_, opener_, opened_);
  const bool is_reply = got.kind == DatagramKind::reply;
  DropReason drop = got.drop;
  if (drop == DropReason::none)
    drop = is_reply ? decode(got.payload, reply, &view_) : decode(got.payload, reason);
  if (drop == DropReason::none && is_reply) {
    if (is_shortened(got.payload)) ++shortened_;
    if (reply.sample_index >= paced_by_) {  // late replies have an old pace
      paced_by_ = reply.sample_index;
      packer_.set_pace(reply.pace);
      slowest_pace_ = std::max(slowest_pace_, packer_.pace());
    }
  }
  if (drop == DropReason::none) return is_reply ? Arrival::reply : Arrival::goodbye;
  ++dropped_[static_cast<std::size_t>(drop)];
  return Arrival::dropped;
}

}  // namespace feltwire
