#pragma once
// Socket options that client and server set for their datagrams.

#include <sys/socket.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

inline constexpr int kMaxDscp = 63;

/// A differentiated services code point by its name (cs0 to cs7, af11 to af43, ef, va: RFC 2474,
/// 2597, 3246, 5865) or its number, 0 to 63. Throws std::invalid_argument that lists the choices.
int dscp(std::string_view text);

/// Marks the datagrams of the UDP socket, over IPv4 and IPv6. False, with errno, if the system
/// refuses.
bool set_dscp(int descriptor, int dscp) noexcept;

/// The mark of the socket's datagrams; for an IPv6 socket that of IPv6.
std::optional<int> get_dscp(int descriptor) noexcept;

/// No datagram of the socket is ever fragmented, here or on the way: one that is too long for the
/// path fails with EMSGSIZE. A lost fragment loses the whole datagram, and many networks drop all
/// fragments. False, with errno, if the system refuses.
bool forbid_fragments(int descriptor) noexcept;

/// [bytes] The longest packet that the system knows the path to this address to take, IP's header
/// included; empty: it has no way there. It opens a socket, and never blocks or allocates.
std::optional<int> path_mtu(const sockaddr_storage& to, socklen_t size) noexcept;

/// [bytes] The headers of IP and UDP before a datagram to this address.
std::size_t header_bytes(const sockaddr_storage& to) noexcept;

}  // namespace feltwire
