#pragma once
// Datagrams sealed and opened: the header stays readable and is authenticated, the payload is
// encrypted. PROTOCOL.md, "Sealing", says the same in bytes.

#include <array>
#include <optional>

#include "protocol/crypto/aead.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/sequence.hpp"

namespace feltwire {

/// Room for one datagram, or for its payload laid out so that it can be read in place.
struct DatagramBuffer {
  alignas(std::uint64_t) std::array<std::uint8_t, kMaxDatagram> bytes;
};

/// A secret is used for 2^22 packet numbers, its generation; then comes the next, by the number
/// alone. Limits for datagrams of l = 75 blocks of 16 bytes and an advantage of 2^-57 (RFC 9001,
/// B.1): AES-GCM seals 2^35 / l = 2^28.8 with one key, 2^23 whatever their length;
/// ChaCha20-Poly1305 has no limit below the number of packets.
inline constexpr int kGenerationBits = 22;
inline constexpr std::uint64_t kLastPacketNumber = ~std::uint64_t{0};
constexpr std::uint64_t generation(std::uint64_t packet_number) noexcept {
  return packet_number >> kGenerationBits;
}

/// From a generation's secret: the next one's, and the key that seals. Neither leads back.
Key next_secret(const Key& secret) noexcept;
Key sealing_key(const Key& secret) noexcept;

/// One direction's sender. It counts the packet numbers itself, so that none is used twice: it does
/// not copy, and one that was moved from seals no more.
class Sealer {
 public:
  /// Goes on after `sent`; `secret` is of that number's generation. Throws std::invalid_argument
  /// where the suite is not supported.
  Sealer(CipherSuite suite, const Key& secret, std::uint64_t sent = 0);
  ~Sealer();
  Sealer(Sealer&& other) noexcept;
  Sealer& operator=(Sealer&& other) noexcept;

  /// Writes the datagram into `out` and returns it: header, sealed payload, tag. Empty, and no
  /// number is used, where the payload has more than kMaxPayload bytes or no number is left.
  Bytes seal(DatagramKind kind, std::uint64_t session, Bytes payload, DatagramBuffer& out) noexcept;

  std::uint64_t sent() const { return sent_; }

 private:
  CipherSuite suite_;
  Key secret_;  // of the generation of sent_
  AeadKey key_;
  std::uint64_t sent_;
};

/// An opened datagram: its payload, within the buffer it was opened into, or the reason to drop it.
struct Opened {
  DropReason drop = DropReason::none;
  Bytes payload;
};

/// The other direction's receiver: replay window and keys. Nothing moves but by a datagram that was
/// sealed with this direction's key.
class Opener {
 public:
  /// Goes on after `highest`, whose generation `secret` is of. After `forgeries` datagrams that
  /// were not sealed with its keys it opens nothing more; never more than forgery_limit(suite).
  /// Throws std::invalid_argument where the suite is not supported.
  Opener(CipherSuite suite, const Key& secret, std::uint64_t highest = 0,
         std::uint64_t forgeries = kLastPacketNumber);
  ~Opener();
  Opener(const Opener&) = default;
  Opener& operator=(const Opener&) = default;

  /// Window, seal, and then the number counts as seen. `header` is what guard() read from
  /// `datagram`, which has kMinDatagram bytes at least.
  Opened open(const Header& header, Bytes datagram, DatagramBuffer& out) noexcept;

  /// Of what was opened, 0: nothing yet.
  std::uint64_t highest() const { return window_.highest(); }
  /// Datagrams whose tag was wrong.
  std::uint64_t forgeries() const { return forgeries_; }
  /// As many as may be.
  bool exhausted() const { return forgeries_ >= forgery_limit_; }

 private:
  const AeadKey* key_of(std::uint64_t packet_number) const noexcept;
  void advance_to(std::uint64_t packet_number) noexcept;

  CipherSuite suite_;
  Key secret_;  // of the next generation
  AeadKey current_, next_;
  std::optional<AeadKey> previous_;  // while the window reaches back to it
  PacketWindow window_;
  std::uint64_t generation_, forgeries_ = 0, forgery_limit_;
};

}  // namespace feltwire
