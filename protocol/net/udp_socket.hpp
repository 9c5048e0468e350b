#pragma once
// Socket options that client and server set for their datagrams.

#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

inline constexpr int kMaxDscp = 63;

/// A differentiated services code point by its name (cs0 to cs7, af11 to af43, ef, va: RFC 2474,
/// 2597, 3246, 5865) or its number, 0 to 63. Throws std::invalid_argument naming the choices.
int dscp(std::string_view text);

/// Marks what the UDP socket sends, over IPv4 and IPv6. False, with errno, where the system
/// refuses.
bool set_dscp(int descriptor, int dscp) noexcept;

/// The mark that the socket puts on its datagrams; of IPv6 where it is an IPv6 socket.
std::optional<int> get_dscp(int descriptor) noexcept;

/// Nothing that the socket sends is ever cut into fragments, here or on the way: what is too long
/// for the path fails with EMSGSIZE. A lost fragment loses the whole datagram, and many networks
/// let none through. False, with errno, where the system refuses.
bool forbid_fragments(int descriptor) noexcept;

}  // namespace feltwire
