#pragma once
// Seals and opens datagrams: the header stays readable and is authenticated, the payload is
// encrypted. PROTOCOL.md, "Sealing", has the bytes.

#include <array>
#include <optional>

#include "protocol/crypto/aead.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/sequence.hpp"

namespace feltwire {

/// Room for one datagram, or for its payload, aligned so that it can be read in place.
struct DatagramBuffer {
  alignas(std::uint64_t) std::array<std::uint8_t, kMaxDatagram> bytes;
};

/// A secret is used for 2^22 packet numbers, its generation. The packet number alone determines the
/// generation. Limits for datagrams of l = 75 blocks of 16 bytes and an advantage of 2^-57 (RFC
/// 9001, B.1): AES-GCM seals 2^35 / l = 2^28.8 with one key, 2^23 for any length; ChaCha20-Poly1305
/// has no limit below the number of packets.
inline constexpr int kGenerationBits = 22;
inline constexpr std::uint64_t kLastPacketNumber = ~std::uint64_t{0};
constexpr std::uint64_t generation(std::uint64_t packet_number) noexcept {
  return packet_number >> kGenerationBits;
}

/// Derives from the secret of a generation that of the next generation, and the key that seals. The
/// secret cannot be computed from either.
Key next_secret(const Key& secret) noexcept;
Key sealing_key(const Key& secret) noexcept;

/// The sender of one direction. It counts the packet numbers itself, so that none is used twice.
/// For the same reason it cannot be copied, and a moved-from sender seals nothing more.
class Sealer {
 public:
  /// Continues after packet number `sent`; `secret` is that of its generation. Throws
  /// std::invalid_argument if the suite is not supported.
  Sealer(CipherSuite suite, const Key& secret, std::uint64_t sent = 0);
  ~Sealer();
  Sealer(Sealer&& other) noexcept;
  Sealer& operator=(Sealer&& other) noexcept;

  /// Writes the datagram into `out` and returns it: header, sealed payload, tag. If the payload has
  /// more than kMaxPayload bytes or no number is left, it returns nothing and uses no number.
  Bytes seal(DatagramKind kind, std::uint64_t session, Bytes payload, DatagramBuffer& out) noexcept;

  std::uint64_t sent() const { return sent_; }

 private:
  CipherSuite suite_;
  Key secret_;  // of the generation of sent_
  AeadKey key_;
  std::uint64_t sent_;
};

/// An opened datagram: its payload, in the buffer that it was opened into, or the reason to drop
/// it.
struct Opened {
  DropReason drop = DropReason::none;
  Bytes payload;
};

/// The receiver of one direction: replay window and keys. Only a datagram that was sealed with this
/// direction's key changes its state.
class Opener {
 public:
  /// Continues after packet number `highest`; `secret` is that of its generation. After `forgeries`
  /// datagrams that were not sealed with its keys, at most forgery_limit(suite), it opens nothing
  /// more. Throws std::invalid_argument if the suite is not supported.
  Opener(CipherSuite suite, const Key& secret, std::uint64_t highest = 0,
         std::uint64_t forgeries = kLastPacketNumber);
  ~Opener();
  Opener(const Opener&) = default;
  Opener& operator=(const Opener&) = default;

  /// Checks the window, then the seal; a valid number then counts as seen. `header` is the result
  /// of guard() for `datagram`. Precondition: the datagram has at least kMinDatagram bytes.
  Opened open(const Header& header, Bytes datagram, DatagramBuffer& out) noexcept;

  /// The highest packet number that was opened, 0: none yet.
  std::uint64_t highest() const { return window_.highest(); }
  /// Number of datagrams with a wrong tag.
  std::uint64_t forgeries() const { return forgeries_; }
  /// Whether the limit of forgeries is reached.
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

/// The datagrams that a client receives: a payload of a known kind, in the buffer that it was
/// opened into, or the reason to drop the datagram.
struct Received {
  DropReason drop = DropReason::none;
  DatagramKind kind = DatagramKind::reply;
  Bytes payload;
};

/// The checks of a client that has one session, in the order of PROTOCOL.md: guard(), the session,
/// the seal. `expected_kinds`: a set_of().
Received receive(Bytes datagram, unsigned expected_kinds, std::uint64_t session, Opener& opener,
                 DatagramBuffer& out) noexcept;

}  // namespace feltwire
