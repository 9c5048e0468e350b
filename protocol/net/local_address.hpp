#pragma once
// The address of this machine that a datagram came to, so that its answer can leave from there.
//
// A UDP socket on every address (0.0.0.0 or ::) answers from the address that the system prefers
// for the way back. A client that spoke to another address of this machine takes no such answer:
// its socket is connected.

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>

namespace feltwire {

struct LocalAddress {
  int family = AF_UNSPEC;  // of the socket; AF_UNSPEC: not known, and the system chooses
  in6_addr six{};          // AF_INET6, where IPv4 is ::ffff:a.b.c.d
  in_addr four{};          // AF_INET
  unsigned interface = 0;  // of a link-local address; 0: any
};

/// Room beside a datagram for its local address.
struct LocalAddressRoom {
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(in6_pktinfo))> bytes;
};

/// AF_INET or AF_INET6 of a socket; AF_UNSPEC: it is none.
int family_of(int descriptor) noexcept;

/// From now on the UDP socket tells the local address of each datagram. Call it where the socket is
/// bound to every address; any other answers from its own. False, with errno, if the system
/// refuses.
bool report_local_address(int descriptor) noexcept;

/// Gives a message room to receive it. Call it again before each use of the message.
void make_room(msghdr& message, LocalAddressRoom& room) noexcept;
/// The local address of a datagram that was received into that room.
LocalAddress local_address(const msghdr& message) noexcept;
/// The datagram of this message leaves from there. `room` must outlive its use.
void leave_from(const LocalAddress& from, msghdr& message, LocalAddressRoom& room) noexcept;

}  // namespace feltwire
