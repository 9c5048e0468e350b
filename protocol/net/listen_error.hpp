#pragma once

#include <asio/ip/address.hpp>
#include <asio/ip/v6_only.hpp>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

#include "protocol/net/link_local.hpp"

namespace feltwire {

/// Makes a socket on :: (every network) accept IPv4 too, for every setting of the system.
template <class Socket>
void serve_both_families(Socket& socket, const asio::ip::address& address) {
  if (address.is_v6() && address.is_unspecified()) socket.set_option(asio::ip::v6_only(false));
}

/// The error for a port that cannot be opened, in one line with the remedy.
inline std::runtime_error listen_error(const char* transport, const asio::ip::address& address,
                                       std::uint16_t port, const std::error_code& code,
                                       const char* port_option = "--port") {
  std::string remedy;
  if (code.value() == EADDRINUSE)
    remedy =
        std::string("; another server may be running, choose another port with ") + port_option;
  else if (code.value() == EACCES)
    remedy = std::string("; choose a port above 1023 with ") + port_option;
  else if (const auto wrong = missing_zone(address))
    remedy = "; " + *wrong;
  else if (code.value() == EADDRNOTAVAIL)
    remedy = "; choose an address of this machine with --address";
  return std::runtime_error("cannot listen on " + address.to_string() + " port " +
                            std::to_string(port) + " (" + transport + "): " + code.message() +
                            remedy);
}

}  // namespace feltwire
