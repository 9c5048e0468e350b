#pragma once
// Opens the server's TCP ports: binds them, and sets up TLS with the server's certificate.

#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <cstdint>

#include "server/access/identity.hpp"

namespace feltwire {

/// Makes the acceptor listen, without blocking. Returns its port. Throws std::runtime_error with
/// one line that names `port_option` if it cannot.
std::uint16_t listen_on(asio::ip::tcp::acceptor& acceptor, const asio::ip::tcp::endpoint& endpoint,
                        const char* port_option = "--port");

/// TLS 1.3 with this certificate and key.
asio::ssl::context server_tls(const Identity& identity);

}  // namespace feltwire
