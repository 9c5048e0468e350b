#pragma once
// Single datagrams, with the address of this machine at which they come and go.

#include <sys/socket.h>
#include <sys/types.h>

#include <cstdint>
#include <span>

#include "protocol/net/local_address.hpp"

namespace feltwire {

/// Receives a datagram without waiting. Returns its size [bytes], at most that of `into`; below 0,
/// with errno: there is none. `length` [bytes] is the room at `from`, and afterwards the length of
/// the sender's address. `local` is known where the socket tells it (report_local_address()).
ssize_t receive_datagram(int descriptor, std::span<std::uint8_t> into, sockaddr* from,
                         socklen_t& length, LocalAddress& local) noexcept;

/// Sends a datagram without waiting. It leaves from the address `from` of this machine. False, with
/// errno: the system did not take it.
bool send_datagram(int descriptor, std::span<const std::uint8_t> datagram, const sockaddr* to,
                   socklen_t length, const LocalAddress& from) noexcept;

}  // namespace feltwire
