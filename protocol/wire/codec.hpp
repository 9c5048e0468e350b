#pragma once
// Payloads of datagrams to bytes and back. Decoding verifies the FlatBuffer before it reads it.

#include <array>
#include <memory>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct SceneView;

/// Builds payloads that a Sealer then seals (protocol/wire/seal.hpp). It allocates only for the
/// first payload of each kind. The returned bytes are valid until the next call.
class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(Encoder&&) noexcept;
  Encoder& operator=(Encoder&&) noexcept;

  Bytes samples(const SampleBatch& batch);
  /// `view`: for an observer's reply. Precondition: such a reply has no model, no normals and no
  /// remote, so that it fits a datagram. `shortened`: the reply says less than it might, because
  /// the path takes no longer datagrams.
  Bytes reply(const Reply& reply, const SceneView* view = nullptr, bool shortened = false);
  Bytes goodbye(GoodbyeReason reason);
  Bytes state(const RobotState& state);
  Bytes target(const RobotTarget& target);

 private:
  struct Builder;
  std::unique_ptr<Builder> builder_;
};

/// Reads a payload that an Opener opened. `out` is unspecified unless the result is
/// DropReason::none.
DropReason decode(Bytes payload, SampleBatch& out) noexcept;
/// Writes the view in the reply to `view`, unless that is null.
DropReason decode(Bytes payload, Reply& out, SceneView* view = nullptr) noexcept;
/// Whether a reply says that it was shortened. Precondition: decode() took it as a reply.
bool is_shortened(Bytes payload) noexcept;
DropReason decode(Bytes payload, GoodbyeReason& out) noexcept;
DropReason decode(Bytes payload, RobotState& out) noexcept;
DropReason decode(Bytes payload, RobotTarget& out) noexcept;

/// The checks of PROTOCOL.md on the samples of a batch: count, order, not_finite.
DropReason check(const SampleBatch& batch) noexcept;

}  // namespace feltwire
