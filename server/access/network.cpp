#include "server/access/network.hpp"

#include <algorithm>

namespace feltwire {

HostAddress host_of(const asio::ip::address& address) {
  HostAddress host{};
  if (address.is_v6() && !address.to_v6().is_v4_mapped()) {
    const auto bytes = address.to_v6().to_bytes();
    std::copy_n(bytes.begin(), host.size(), host.begin());
    return host;
  }
  const auto bytes =
      address.is_v4() ? address.to_v4().to_bytes()
                      : asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_bytes();
  // Four bytes mark an IPv4 address. No assigned IPv6 network begins with them.
  host = {0xff, 0xff, 0xff, 0xff, bytes[0], bytes[1], bytes[2], bytes[3]};
  return host;
}

Network network_of(const asio::ip::address& address) {
  Network network = host_of(address);
  // [bytes] that identify a network: of an IPv6 address, and of an IPv4 address with its mark.
  constexpr std::size_t kBytesOfSix = 6, kBytesOfFour = 7;
  const bool four = address.is_v4() || address.to_v6().is_v4_mapped();
  std::fill(network.begin() + (four ? kBytesOfFour : kBytesOfSix), network.end(), std::uint8_t{0});
  return network;
}

}  // namespace feltwire
