#pragma once
// The datagrams of one session as bytes: samples become datagrams, datagrams become replies. No
// socket, no clock.

#include <array>
#include <cstdint>

#include "client/transport/sample_packer.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"

namespace feltwire {

class DatagramSession {
 public:
  enum class Arrival { dropped, reply, goodbye };

  /// `keys`: of this session alone. `parameters`: as the server granted them; they say how often
  /// datagrams are due and what is in them. `rotation`: orientation and torque travel too. `scale`:
  /// of a position deadband. Only this constructor allocates.
  DatagramSession(std::uint64_t session, const SessionKeys& keys,
                  const SessionParameters& parameters, bool rotation,
                  const PositionScale& scale = {});

  /// Continues with another session and its keys. Packet numbers restart, and late datagrams of
  /// the old session are dropped. Precondition: the suite of the keys is supported.
  void resume(std::uint64_t session, const SessionKeys& keys) noexcept;

  /// Returns the datagram that is due with this sample (client/transport/sample_packer.hpp); empty
  /// if none is. Call it with every sample. The bytes are valid until the next call of pack() or
  /// goodbye(). The report travels with it, and the lead of a hand for this sample.
  Bytes pack(const Sample& sample, const std::optional<HandReport>& report = {},
             const std::optional<Lead>& lead = {}) noexcept;
  Bytes goodbye() noexcept;

  /// Puts one sample less into each datagram until the next session, because the path allows no
  /// longer ones. Returns false if only one is left.
  bool carry_fewer() noexcept { return packer_.carry_fewer(); }

  /// Reads a datagram, with all checks of PROTOCOL.md in their order, and counts the dropped ones.
  /// Fills `reply` or `reason`, as the result says.
  Arrival take(Bytes datagram, Reply& reply, GoodbyeReason& reason) noexcept;

  /// An observer's view in the last reply; null: it had none. Valid until the next take().
  const SceneView* view() const { return view_.present ? &view_ : nullptr; }

  /// The most packet intervals between two datagrams, as the server asked (SamplePacker::pace()).
  int slowest_pace() const noexcept { return slowest_pace_; }

  const std::array<std::uint64_t, kDropReasons>& dropped() const { return dropped_; }
  /// Replies that say less than they might, because the path takes no longer ones.
  std::uint64_t shortened() const { return shortened_; }

 private:
  std::uint64_t session_;
  Encoder encoder_;
  SamplePacker packer_;
  Sealer sealer_;  // of datagrams to the server
  Opener opener_;  // of datagrams from it
  DatagramBuffer sealed_, opened_;
  SceneView view_;
  std::array<std::uint64_t, kDropReasons> dropped_{};
  std::uint64_t shortened_ = 0;
  int slowest_pace_ = 1;
  std::uint64_t paced_by_ = 0;  // the newest sample whose reply had a pace
};

}  // namespace feltwire
