#include "protocol/net/link_local.hpp"

#include <net/if.h>

namespace feltwire {
namespace {

/// Returns the names of this machine's interfaces without the loopback, for example "eth0, wlan0".
std::string interfaces() {
  std::string names;
  auto* const all = ::if_nameindex();
  if (all == nullptr) return names;
  for (const auto* one = all; one->if_index != 0; ++one)
    if (std::string(one->if_name) != "lo")
      names += (names.empty() ? "" : ", ") + std::string(one->if_name);
  ::if_freenameindex(all);
  return names;
}

}  // namespace

std::optional<std::string> missing_zone(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_link_local() || address.to_v6().scope_id() != 0)
    return std::nullopt;
  const std::string text = address.to_string(), names = interfaces();
  const std::string first = names.empty() ? "eth0" : names.substr(0, names.find(','));
  return text +
         " is a link-local IPv6 address, which is another machine on each network; name the "
         "network's interface as its zone: " +
         text + "%" + first + (names.empty() ? std::string() : " (interfaces here: " + names + ")");
}

}  // namespace feltwire
