#pragma once

#include <asio/ip/address.hpp>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

namespace feltwire {

/// One line for whoever started the server on a port that cannot be had.
inline std::runtime_error listen_error(const char* transport, const asio::ip::address& address,
                                       std::uint16_t port, const std::error_code& code) {
  std::string remedy;
  if (code.value() == EADDRINUSE)
    remedy = "; another server may be running, choose another port with --port";
  else if (code.value() == EACCES)
    remedy = "; choose a port above 1023 with --port";
  else if (code.value() == EADDRNOTAVAIL)
    remedy = "; choose an address of this machine with --address";
  return std::runtime_error("cannot listen on " + address.to_string() + " port " +
                            std::to_string(port) + " (" + transport + "): " + code.message() +
                            remedy);
}

}  // namespace feltwire
