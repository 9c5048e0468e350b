#pragma once

#include "protocol/datagram.hpp"

namespace feltwire {

inline constexpr std::size_t kHeaderSize = 24;  // [bytes]

struct Guarded {
  DropReason drop = DropReason::none;
  Header header;
  Bytes payload;  // into the datagram
};

/// Size and header, in the order of PROTOCOL.md; touches nothing behind the header. `expected` are the kinds this side
/// receives, as bits 1 << kind.
Guarded guard(Bytes datagram, unsigned expected_kinds) noexcept;

}  // namespace feltwire
