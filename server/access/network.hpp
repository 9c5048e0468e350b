#pragma once
// The addresses that count as one network for the limits.

#include <array>
#include <asio/ip/address.hpp>
#include <cstdint>

namespace feltwire {

/// A network, or the addresses of one host, as a key: none of IPv4 has a key of IPv6.
using Network = std::array<std::uint8_t, 8>;
using HostAddress = std::array<std::uint8_t, 8>;

/// Returns the network of an address. IPv6: the first 48 bits, the most that one site usually gets.
/// IPv4: the first 24 bits, the smallest network that is routed on the internet; a few rented
/// addresses mostly lie in one. An IPv4 address in IPv6 (::ffff:a.b.c.d) counts as IPv4.
Network network_of(const asio::ip::address& address);

/// Returns what one host has of its network. IPv6: the first 64 bits, because every host gets that
/// many addresses. IPv4: the whole address.
HostAddress host_of(const asio::ip::address& address);

}  // namespace feltwire
