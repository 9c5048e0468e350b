#include "server/access/network.hpp"

#include <algorithm>

namespace feltwire {

Network network_of(const asio::ip::address& address) {
  Network network{};
  if (address.is_v6() && !address.to_v6().is_v4_mapped()) {
    const auto bytes = address.to_v6().to_bytes();
    std::copy_n(bytes.begin(), network.size(), network.begin());
    return network;
  }
  const auto bytes =
      address.is_v4() ? address.to_v4().to_bytes()
                      : asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_bytes();
  // No network of IPv6 that is given out begins with these four bytes.
  network = {0xff, 0xff, 0xff, 0xff, bytes[0], bytes[1], bytes[2], 0};
  return network;
}

}  // namespace feltwire
