#pragma once
// A port behind which a program's own simulator stands in the place of a server.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "client/simulator/simulator_contact.hpp"
#include "client/simulator/simulator_feed.hpp"
#include "client/transport/datagram_port.hpp"
#include "core/local_model/local_contact.hpp"
#include "protocol/crypto/session_keys.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/seal.hpp"

namespace feltwire {

/// Takes a hand's samples, and answers them as a server would, with the newest contact of the
/// simulator. A contact is answered once. So the force of a simulator that stops fades by the
/// session's hold time. A port has no thread and waits for nothing: the servo thread does its work.
class SimulatorPort final : public DatagramPort {
 public:
  /// Poses that a contact may refer to: those of the last kPoses samples.
  static constexpr std::size_t kPoses = 2048;
  using Clock = Nanoseconds (*)() noexcept;

  /// `keys`: of the hand's session. `feed`: what the simulator says; never null. `clock`: that of
  /// the samples.
  SimulatorPort(std::uint64_t session, const SessionKeys& keys, std::shared_ptr<SimulatorFeed> feed,
                Clock clock = monotonic_now);

  bool connect(const Address& /*server*/) noexcept override { return true; }
  bool reroute() noexcept override { return true; }
  void send(Bytes datagram) noexcept override;
  std::optional<Bytes> receive() noexcept override;
  int descriptor() const noexcept override { return feed_->descriptor(); }
  PortStatistics statistics() const noexcept override { return statistics_; }

 private:
  struct Seen {
    Nanoseconds time{0};
    Vec3 position = Vec3::Zero();
  };
  const Seen& seen_at(Nanoseconds time) const noexcept;
  Reply answer(SimulatorContact contact) noexcept;

  std::uint64_t session_;
  std::shared_ptr<SimulatorFeed> feed_;
  Clock clock_;
  Opener opener_;  // of the hand's datagrams
  Sealer sealer_;  // of the answers
  Encoder encoder_;
  DatagramBuffer opened_, sealed_;
  SampleBatch batch_;
  Sample newest_;  // of the hand; index 0: there was none yet
  std::array<Seen, kPoses> poses_{};
  std::uint64_t pose_count_ = 0;
  std::uint64_t answered_ = 0;  // index of the last sample that was answered
  std::uint64_t answers_ = 0;
  std::optional<SimulatorContact> waiting_;  // for a newer sample
  LocalContact contact_;
  PortStatistics statistics_;
};

}  // namespace feltwire
