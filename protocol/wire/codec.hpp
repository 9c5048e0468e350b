#pragma once
// Payloads of datagrams to bytes and back. Decoding verifies the FlatBuffer before it reads it.

#include <array>
#include <memory>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct SceneView;

/// Builds payloads, to be sealed (protocol/wire/seal.hpp). After the first of each kind it does not
/// allocate. The bytes returned live until the next call.
class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(Encoder&&) noexcept;
  Encoder& operator=(Encoder&&) noexcept;

  Bytes samples(const SampleBatch& batch);
  /// With a `view` for an observer, whose replies have no model.
  Bytes reply(const Reply& reply, const SceneView* view = nullptr);
  Bytes goodbye(GoodbyeReason reason);

 private:
  struct Builder;
  std::unique_ptr<Builder> builder_;
};

/// A payload that was opened. On anything but DropReason::none `out` is unspecified.
DropReason decode(Bytes payload, SampleBatch& out) noexcept;
/// The view in the reply goes to `view`, if that is not null.
DropReason decode(Bytes payload, Reply& out, SceneView* view = nullptr) noexcept;
DropReason decode(Bytes payload, GoodbyeReason& out) noexcept;

/// The checks of PROTOCOL.md on the samples of a batch: count, order, not_finite.
DropReason check(const SampleBatch& batch) noexcept;

}  // namespace feltwire
