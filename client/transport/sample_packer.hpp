#pragma once
// Which samples travel: one servo tick after another goes in, now and then a datagram's samples
// come out. No socket, no clock.

#include <cstddef>
#include <vector>

#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// The scale of a position deadband; 0: not known.
struct PositionScale {
  double quantum = 0.0;    // [m] the device's encoder
  double stiffness = 0.0;  // [N/m] K of the scene's stiffest surface (JoinAccepted)
};

/// A datagram is due every `packet_interval` ticks, n; the first sample of a session, at once. It
/// brings `batch` of the newest n samples, evenly spaced, the newest among them, and the
/// `redundancy` that travelled before once more.
///
/// With a `position_deadband` k a datagram that is due stays away while the server still knows well
/// enough where the tool is. A position has no Weber fraction of its own: nobody feels where the
/// world's origin is. What is felt is the force that comes of it, so the fraction is one of force:
///
///   in contact, |f| held: |x - x_known| <= k |f| / K: the elastic force of no surface is wrong by
///     more than k of what is felt. K not known: as in free space, the smaller way to be wrong.
///   in free space: |x - x_known| <= k |v| tau. There the hand feels nothing yet, and what must not
///     suffer is the onset: moving on at v it leaves the deadband k tau after the position known,
///     so the server learns of a wall at most k tau + n T late (10 %: 2 ms + n T), and the tool is
///     by then at most k |v| tau + |v| n T deeper than the server knew, a step of K times that.
///   ever: one encoder quantum, which says nothing.
///
/// It is sent all the same where force begins or ends, and when the server would else hear nothing
/// for longer than `keep_alive`. Rotation: 1 mrad, or k times what the tool turns within tau.
///
/// Memory is taken at construction; nothing is allocated or thrown afterwards.
class SamplePacker {
 public:
  /// tau [s]: the age of a position in free space that counts as all of it.
  static constexpr double kFreeAge = 0.02;
  static constexpr double kUnfeltAngle = 1e-3;  // [rad]

  /// `parameters` must be valid; `rotation`: orientation and torque travel too.
  SamplePacker(const SessionParameters& parameters, bool rotation, const PositionScale& scale = {});

  /// The samples of the datagram that is due with this one, null when none is. They live until the
  /// next call. Precondition: indices rise.
  const SampleBatch* add(const Sample& sample) noexcept;

  /// A new session: it has missed nothing of the old one.
  void restart() noexcept;

  /// The path does not take datagrams as long as these: from now on they bring one sample less.
  /// False when they bring one only.
  bool carry_fewer() noexcept;

 private:
  bool due(const Sample& sample) const noexcept;
  bool known(const Sample& sample) const noexcept;
  void make(std::uint64_t fresh) noexcept;
  const Sample& recent(std::uint64_t ago) const noexcept;

  SessionParameters parameters_;
  PositionScale scale_;
  int most_;           // samples in a datagram, as far as the path takes them
  SampleBatch batch_;  // the last one made
  // Samples that travelled, the newest first: what the next datagram repeats, and one more.
  std::array<Sample, kMaxRedundancy + 1> travelled_{};
  int travelled_count_ = 0;
  std::vector<Sample> recent_;     // a ring of the newest n; of the newest alone where one travels
  std::uint64_t fed_ = 0;          // samples of this session
  std::uint64_t fed_at_last_ = 0;  // when the last datagram was made; 0: none yet
  // How the tool moved from the datagram before to the last.
  Vec3 velocity_ = Vec3::Zero();          // [m/s]
  Vec3 angular_velocity_ = Vec3::Zero();  // [rad/s]
};

}  // namespace feltwire
