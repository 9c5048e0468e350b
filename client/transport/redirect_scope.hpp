#pragma once
// The rule about the hosts that a server may name to a client (PROTOCOL.md, "Redirects").

#include <asio/ip/address.hpp>
#include <optional>
#include <string>

#include "protocol/wire/control.hpp"

namespace feltwire {

/// Checks a host that the server at the address `by` names, in a redirect or as another host of its
/// fleet. Returns why the client must not connect there, for people; empty: it may.
///
/// A host is named by its IP address, and its network is at least as wide as that of the server:
/// this machine, a private network, the internet. So no server on the internet makes a client
/// connect to machines that only the client can reach.
std::optional<std::string> forbidden_host(const asio::ip::address& by,
                                          const control::FleetHost& named);

}  // namespace feltwire
