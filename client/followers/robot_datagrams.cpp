#include "client/followers/robot_datagrams.hpp"

namespace feltwire {
namespace {

constexpr unsigned kForRobots = set_of({DatagramKind::follower_target, DatagramKind::goodbye});

}  // namespace

RobotDatagrams::RobotDatagrams(std::uint64_t session, const SessionKeys& keys)
    : session_(session), sealer_(keys.suite, keys.up), opener_(keys.suite, keys.down) {
  encoder_.state({});  // the first encoding allocates memory, so do it before the loop
  encoder_.goodbye(GoodbyeReason::leaving);
}

Bytes RobotDatagrams::pack(const RobotState& state) noexcept {
  return sealer_.seal(DatagramKind::follower_state, session_, encoder_.state(state), sealed_);
}

Bytes RobotDatagrams::goodbye() noexcept {
  return sealer_.seal(DatagramKind::goodbye, session_, encoder_.goodbye(GoodbyeReason::leaving),
                      sealed_);
}

RobotDatagrams::Arrival RobotDatagrams::take(Bytes datagram, RobotTarget& target,
                                             GoodbyeReason& reason) noexcept {
  const Received got = receive(datagram, kForRobots, session_, opener_, opened_);
  const bool is_target = got.kind == DatagramKind::follower_target;
  RobotTarget read;  // decode into a copy, so that a dropped datagram leaves `target` unchanged
  DropReason drop = got.drop;
  if (drop == DropReason::none)
    drop = is_target ? decode(got.payload, read) : decode(got.payload, reason);
  if (drop != DropReason::none) {
    ++dropped_[static_cast<std::size_t>(drop)];
    return Arrival::dropped;
  }
  if (!is_target) return Arrival::goodbye;
  target = read;
  return Arrival::target;
}

}  // namespace feltwire
