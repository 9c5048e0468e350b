#pragma once
// Consecutive UDP ports after the control port.

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <vector>

#include "protocol/net/listen_error.hpp"

namespace feltwire {

/// Opens sockets on `count` ports from `first` on. Throws std::runtime_error with one line if one
/// cannot be opened.
inline std::vector<asio::ip::udp::socket> open_scene_ports(asio::io_context& io,
                                                           const asio::ip::address& address,
                                                           unsigned first, std::size_t count,
                                                           const char* port_option = "--port") {
  std::vector<asio::ip::udp::socket> sockets;
  for (std::size_t i = 0; i < count; ++i) {
    const auto port = static_cast<std::uint16_t>(first + i);
    try {
      if (first + i > 65535) throw std::system_error(EADDRINUSE, std::generic_category());
      const asio::ip::udp::endpoint endpoint(address, port);
      auto& socket = sockets.emplace_back(io);
      socket.open(endpoint.protocol());
      serve_both_families(socket, address);
      socket.bind(endpoint);
    } catch (const std::system_error& error) {
      throw listen_error("udp", address, port, error.code(), port_option);
    }
  }
  return sockets;
}

/// Calls listen(port). If `port` is 0 and the ports after the system's choice are used (listen
/// throws std::runtime_error), it tries again until all ports are free.
template <class Listen>
auto listen_with_room(std::uint16_t port, Listen listen) {
  constexpr int kTries = 100;
  for (int tries = 1;; ++tries) {
    try {
      return listen(port);
    } catch (const std::runtime_error&) {
      if (port != 0 || tries == kTries) throw;
    }
  }
}

}  // namespace feltwire
