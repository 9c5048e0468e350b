#include "server/access/listening.hpp"

#include <openssl/ssl.h>

#include <system_error>

#include "protocol/crypto/tls.hpp"
#include "protocol/net/listen_error.hpp"

namespace feltwire {
namespace {

constexpr long kMostCertificates = 16L * 1024;  // [bytes] largest size of a client's certificates

}  // namespace

std::uint16_t listen_on(asio::ip::tcp::acceptor& acceptor, const asio::ip::tcp::endpoint& endpoint,
                        const char* port_option) {
  try {
    acceptor.open(endpoint.protocol());
    // Old connections of a server that has just ended must not block the port. A running server
    // still blocks it.
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
  // Limit the size, because OpenSSL allocates as much memory as a client announces for its
  // certificates.
  SSL_CTX_set_max_cert_list(tls.native_handle(), kMostCertificates);
  tls.use_certificate_chain(asio::buffer(identity.certificate));
  tls.use_private_key(asio::buffer(identity.key.text().data(), identity.key.text().size()),
                      asio::ssl::context::pem);
  return tls;
}

}  // namespace feltwire
