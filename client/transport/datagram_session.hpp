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

  /// `keys` are of this session alone; `parameters` as the server granted them: how often datagrams
  /// are due and what is in them; `rotation`: orientation and torque travel too; `scale`: of a
  /// position deadband. Takes all its memory here.
  DatagramSession(std::uint64_t session, const SessionKeys& keys,
                  const SessionParameters& parameters, bool rotation,
                  const PositionScale& scale = {});

  /// Goes on with another session and its keys: numbers begin anew, and what still comes of the old
  /// one is dropped. Precondition: their suite is supported.
  void resume(std::uint64_t session, const SessionKeys& keys) noexcept;

  /// The datagram that is due with this sample (client/transport/sample_packer.hpp), empty when
  /// none is. To be given every sample. The bytes live until the next call of pack() or goodbye().
  Bytes pack(const Sample& sample) noexcept;
  Bytes goodbye() noexcept;

  /// From now on one sample less in a datagram, until the next session: the path takes no longer
  /// ones. False when one alone is left.
  bool carry_fewer() noexcept { return packer_.carry_fewer(); }

  /// Reads a datagram, all checks of PROTOCOL.md in their order; what fails one is counted. Fills
  /// `reply` or `reason`, as the result says.
  Arrival take(Bytes datagram, Reply& reply, GoodbyeReason& reason) noexcept;

  /// The view in the last reply taken, for an observer; null: it had none. Valid until the next
  /// take().
  const SceneView* view() const { return view_.present ? &view_ : nullptr; }

  const std::array<std::uint64_t, kDropReasons>& dropped() const { return dropped_; }

 private:
  std::uint64_t session_;
  Encoder encoder_;
  SamplePacker packer_;
  Sealer sealer_;  // of what goes
  Opener opener_;  // of what comes
  DatagramBuffer sealed_, opened_;
  SceneView view_;
  std::array<std::uint64_t, kDropReasons> dropped_{};
};

}  // namespace feltwire
