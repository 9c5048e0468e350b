#pragma once
// The UDP sockets of the scenes. All are at one port if the kernel can tell the scenes apart.

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <vector>

#include "protocol/net/listen_error.hpp"

namespace feltwire {

/// Opens sockets on `count` ports from `first` on. Throws std::runtime_error with one line if one
/// cannot be opened.
std::vector<asio::ip::udp::socket> open_scene_ports(asio::io_context& io,
                                                    const asio::ip::address& address,
                                                    unsigned first, std::size_t count,
                                                    const char* port_option = "--port");

/// Makes sockets at one port a group in which the kernel gives a datagram to the socket whose index
/// is the low byte of the datagram's session (PROTOCOL.md). The sockets count in the order of their
/// binding, so none may be closed before the others. A datagram without such a socket goes to any
/// of them. Returns false if the kernel cannot do that. Needs no permission.
bool steer_by_session(asio::ip::udp::socket& one_of_them);

/// Opens a socket for each of `count` scenes, in their order, all at `port` (0: a free one). Where
/// the kernel gives no group of sockets, each scene gets a port of its own, from `port` on.
/// `steer`: for tests. Throws as open_scene_ports() does.
std::vector<asio::ip::udp::socket> open_scene_sockets(
    asio::io_context& io, const asio::ip::address& address, unsigned port, std::size_t count,
    bool (*steer)(asio::ip::udp::socket&) = steer_by_session);

/// Calls listen(port). If `port` is 0 and the port after the system's choice is used (listen
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
