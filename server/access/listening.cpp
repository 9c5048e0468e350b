#include "server/access/listening.hpp"

#include <system_error>

#include "protocol/crypto/tls.hpp"
#include "protocol/net/listen_error.hpp"

namespace feltwire {

std::uint16_t listen_on(asio::ip::tcp::acceptor& acceptor, const asio::ip::tcp::endpoint& endpoint,
                        const char* port_option) {
  try {
    acceptor.open(endpoint.protocol());
    // Connections of a server that ended a moment ago must not keep the port; a living one still
    // does.
    acceptor.set_option(asio::ip::tcp::acceptor::reuse_address(true));
    serve_both_families(acceptor, endpoint.address());
    acceptor.bind(endpoint);
    acceptor.listen();
    acceptor.non_blocking(true);
    return acceptor.local_endpoint().port();
  } catch (const std::system_error& error) {
    throw listen_error("tcp", endpoint.address(), endpoint.port(), error.code(), port_option);
  }
}

asio::ssl::context server_tls(const Identity& identity) {
  asio::ssl::context tls(new_tls_context(TLS_server_method()));
  require_tls_13(*tls.native_handle());
  tls.use_certificate_chain(asio::buffer(identity.certificate));
  tls.use_private_key(asio::buffer(identity.key.text().data(), identity.key.text().size()),
                      asio::ssl::context::pem);
  return tls;
}

}  // namespace feltwire
