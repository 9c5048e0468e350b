#pragma once

#include <initializer_list>

#include "protocol/crypto/aead.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

inline constexpr std::size_t kHeaderSize = 24;                        // [bytes]
inline constexpr std::size_t kOverhead = kHeaderSize + kTagSize;      // of a datagram
inline constexpr std::size_t kMinDatagram = kOverhead;                // nothing in it
inline constexpr std::size_t kMaxPayload = kMaxDatagram - kOverhead;  // before it is sealed
inline constexpr std::array<std::uint8_t, 2> kMagic = {'F', 'W'};
inline constexpr std::uint8_t kProtocolVersion = 1;

/// The set of these kinds, as bits 1 << kind.
constexpr unsigned set_of(std::initializer_list<DatagramKind> kinds) {
  unsigned bits = 0;
  for (const DatagramKind kind : kinds) bits |= 1u << static_cast<unsigned>(kind);
  return bits;
}

struct Guarded {
  DropReason drop = DropReason::none;
  Header header;
};

/// Checks size and header, in the order of PROTOCOL.md. It reads nothing after the header.
/// `expected_kinds`: the kinds that this side receives, a set_of().
Guarded guard(Bytes datagram, unsigned expected_kinds) noexcept;

/// Writes the header into the first kHeaderSize bytes of `datagram`, which must be that long.
void write_header(std::span<std::uint8_t> datagram, const Header& header) noexcept;

}  // namespace feltwire
