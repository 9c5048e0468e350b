#pragma once
// Chooses the samples that travel: it gets every servo sample, and now and then returns the samples
// of a datagram. It has no socket and no clock.

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

/// A datagram is due every `packet_interval` ticks, n, and with the first sample of a session. It
/// has `batch` of the newest n samples, evenly spaced, with the newest among them. It repeats the
/// `redundancy` samples that travelled before.
///
/// With a `position_deadband` k, a datagram that is due is not sent while the server still knows
/// the tool's position well enough. A position has no Weber fraction of its own: nobody feels where
/// the world's origin is. The hand feels the force that follows, so k is a fraction of the force:
///
///   in contact, |f| held: |x - x_known| <= k |f| / K. So the elastic force of no surface is wrong
///     by more than k of the force felt. Where K is not known, the limit of free space holds, which
///     is the smaller error.
///   in free space: |x - x_known| <= k |v| tau. There the hand feels nothing yet, and only the
///   onset
///     of a contact must not suffer. A tool that moves on at v leaves the deadband k tau after the
///     known position. So the server learns of a wall at most k tau + n T late (10 %: 2 ms + n T).
///     By then the tool is at most k |v| tau + |v| n T deeper than the server knew, and the force
///     steps by K times that.
///   always: a difference of one encoder quantum, which says nothing.
///
/// The datagram is sent all the same where force begins or ends, and before the server has heard
/// nothing for longer than `keep_alive`. The limit of a rotation is 1 mrad, or k times the tool's
/// turn within tau.
///
/// All memory is taken at construction. Nothing is allocated or thrown afterwards.
class SamplePacker {
 public:
  /// tau [s]: in free space the deadband is the share k of the way in this time.
  static constexpr double kFreeAge = 0.02;
  static constexpr double kUnfeltAngle = 1e-3;  // [rad]

  /// `parameters` must be valid; `rotation`: orientation and torque travel too.
  SamplePacker(const SessionParameters& parameters, bool rotation, const PositionScale& scale = {});

  /// The samples of the datagram that is due with this sample, and the report with them; null when
  /// none is due. They live until the next call. The lead is of this sample; if its switch or its
  /// seat has changed since the last datagram, one is due. Precondition: indices rise.
  const SampleBatch* add(const Sample& sample, const std::optional<HandReport>& report = {},
                         const std::optional<Lead>& lead = {}) noexcept;

  /// Begins a new session, which needs no sample of the old one.
  void restart() noexcept;

  /// The server is out of time, and asks for a datagram only every `pace` packet intervals. No pace
  /// is slower than slowest_pace(). The device's own loop keeps its rate.
  void set_pace(int pace) noexcept;
  /// The pace that is kept; 1: a datagram every packet interval.
  int pace() const noexcept { return pace_; }

  /// Puts one sample less into each datagram, as the path takes no longer ones. Returns false when
  /// they have only one.
  bool carry_fewer() noexcept;

 private:
  bool due(const Sample& sample) const noexcept;
  bool known(const Sample& sample) const noexcept;
  void make(std::uint64_t fresh) noexcept;
  const Sample& recent(std::uint64_t ago) const noexcept;

  SessionParameters parameters_;
  PositionScale scale_;
  int most_;           // samples in a datagram, as far as the path takes them
  int pace_ = 1;       // packet intervals between two datagrams
  SampleBatch batch_;  // the last one made
  // Samples that travelled, the newest first: those that the next datagram repeats, and one more.
  std::array<Sample, kMaxRedundancy + 1> travelled_{};
  int travelled_count_ = 0;
  std::vector<Sample> recent_;     // a ring of the newest n; of the newest alone where one travels
  std::uint64_t fed_ = 0;          // samples of this session
  std::uint64_t fed_at_last_ = 0;  // when the last datagram was made; 0: none yet
  // The velocity of the tool from the datagram before the last to the last.
  Vec3 velocity_ = Vec3::Zero();          // [m/s]
  Vec3 angular_velocity_ = Vec3::Zero();  // [rad/s]
};

}  // namespace feltwire
