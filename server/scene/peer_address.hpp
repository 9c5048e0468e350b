#pragma once

#include <sys/socket.h>

#include "protocol/net/local_address.hpp"

namespace feltwire {

/// The address of a datagram's sender, to which its answer goes, and the address of this machine
/// that the sender spoke to, from which the answer leaves.
struct Peer {
  sockaddr_storage address{};
  socklen_t length = 0;  // [bytes] 0: not known yet
  LocalAddress local{};
};

}  // namespace feltwire
