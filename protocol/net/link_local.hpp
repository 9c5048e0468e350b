#pragma once
// IPv6 addresses that are good on one link only (fe80::/10), and the zone that says on which.

#include <asio/ip/address.hpp>
#include <optional>
#include <string>

namespace feltwire {

/// Returns the fault of a link-local address without a zone, and the remedy; empty: it is no such
/// address.
std::optional<std::string> missing_zone(const asio::ip::address& address);

}  // namespace feltwire
