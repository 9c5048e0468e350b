#pragma once
// How the server's TCP ports begin: bound, and with TLS in the server's name.

#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <cstdint>

#include "server/access/identity.hpp"

namespace feltwire {

/// Has the acceptor listen, without blocking. Returns its port. Throws std::runtime_error in one
/// line that names `port_option` where it cannot.
std::uint16_t listen_on(asio::ip::tcp::acceptor& acceptor, const asio::ip::tcp::endpoint& endpoint,
                        const char* port_option = "--port");

/// TLS 1.3 with this certificate and key.
asio::ssl::context server_tls(const Identity& identity);

}  // namespace feltwire
