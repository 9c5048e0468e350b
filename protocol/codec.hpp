#pragma once
// Datagrams to bytes and back. Decoding verifies the FlatBuffer before it reads it.

#include <array>
#include <memory>

#include "protocol/datagram.hpp"

namespace feltwire {

/// Builds whole datagrams (header and payload). After the first of each kind it does not allocate.
/// The bytes returned live until the next call.
class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(Encoder&&) noexcept;
  Encoder& operator=(Encoder&&) noexcept;

  Bytes samples(std::uint64_t session, std::uint64_t packet_number, const SampleBatch& batch);
  Bytes reply(std::uint64_t session, std::uint64_t packet_number, const Reply& reply);
  Bytes goodbye(std::uint64_t session, std::uint64_t packet_number, GoodbyeReason reason);

 private:
  struct Builder;
  std::unique_ptr<Builder> builder_;
};

/// The payload that guard() found behind the header. On anything but DropReason::none `out` is
/// unspecified.
DropReason decode(Bytes payload, SampleBatch& out) noexcept;
DropReason decode(Bytes payload, Reply& out) noexcept;
DropReason decode(Bytes payload, GoodbyeReason& out) noexcept;

/// The checks of PROTOCOL.md that a batch must pass whoever made it: count, order, not_finite.
DropReason check(const SampleBatch& batch) noexcept;

}  // namespace feltwire
