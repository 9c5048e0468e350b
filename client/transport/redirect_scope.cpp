#include "client/transport/redirect_scope.hpp"

#include <array>
#include <string_view>
#include <system_error>

#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

/// Networks by their width. No server names an address of a single link: it has a meaning for the
/// machines of that link only.
enum class Scope { none, machine, link, private_network, internet };

constexpr std::array<std::string_view, 5> kScopeNames = {"no host", "this machine", "a single link",
                                                         "a private network", "the internet"};

std::string_view text(Scope scope) { return kScopeNames.at(static_cast<std::size_t>(scope)); }

bool within(std::uint32_t address, std::uint32_t network, unsigned bits) {
  return (address ^ network) >> (32 - bits) == 0;
}

Scope scope_of(const asio::ip::address_v4& address) {
  const std::uint32_t number = address.to_uint();
  if (within(number, 0, 8) || address.is_multicast() || within(number, 0xf0000000, 4))
    return Scope::none;  // 0.0.0.0/8, 224.0.0.0/4, 240.0.0.0/4
  if (address.is_loopback()) return Scope::machine;
  if (within(number, 0xa9fe0000, 16)) return Scope::link;  // 169.254.0.0/16
  // RFC 1918, and 100.64.0.0/10 of RFC 6598.
  const bool local = within(number, 0x0a000000, 8) || within(number, 0xac100000, 12) ||
                     within(number, 0xc0a80000, 16) || within(number, 0x64400000, 10);
  return local ? Scope::private_network : Scope::internet;
}

Scope scope_of(const asio::ip::address& address) {
  if (address.is_v4()) return scope_of(address.to_v4());
  const asio::ip::address_v6 v6 = address.to_v6();
  if (v6.is_v4_mapped()) return scope_of(asio::ip::make_address_v4(asio::ip::v4_mapped, v6));
  if (v6.is_unspecified() || v6.is_multicast()) return Scope::none;
  if (v6.is_loopback()) return Scope::machine;
  if (v6.is_link_local()) return Scope::link;
  constexpr unsigned kUniqueLocal = 0xfc, kUniqueLocalMask = 0xfe;  // fc00::/7, RFC 4193
  return (v6.to_bytes()[0] & kUniqueLocalMask) == kUniqueLocal ? Scope::private_network
                                                               : Scope::internet;
}

}  // namespace

std::optional<std::string> forbidden_host(const asio::ip::address& by,
                                          const control::FleetHost& named) {
  std::error_code no_address;
  const asio::ip::address address = asio::ip::make_address(named.address, no_address);
  if (no_address) return "'" + visible(named.address) + "', which is no IP address";
  if (named.port == 0) return named.address + " without a port";
  const Scope server = scope_of(by), host = scope_of(address);
  if (host == Scope::none || host == Scope::link)
    return named.address + ", which is an address of " + std::string(text(host));
  if (host >= server) return std::nullopt;
  return named.address + ", which is in " + std::string(text(host)) + ", while the server is in " +
         std::string(text(server));
}

}  // namespace feltwire
