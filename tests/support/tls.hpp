#pragma once
// TLS over blocking sockets by OpenSSL alone, as the reference for our two ends.

#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <csignal>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "protocol/crypto/tls.hpp"
#include "tests/support/security.hpp"

namespace feltwire::test {

using TlsContext = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;

inline void use(SSL_CTX* context, const Identity& identity) {
  const auto bio = [](std::string_view text) {
    return std::unique_ptr<BIO, decltype(&BIO_free_all)>(
        BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), &BIO_free_all);
  };
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(bio(identity.certificate).get(), nullptr, nullptr, nullptr), &X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      PEM_read_bio_PrivateKey(bio(identity.key.text()).get(), nullptr, nullptr, nullptr),
      &EVP_PKEY_free);
  if (SSL_CTX_use_certificate(context, certificate.get()) != 1 ||
      SSL_CTX_use_PrivateKey(context, key.get()) != 1)
    throw std::runtime_error("no identity: " + last_tls_error());
}

/// The context of a client that trusts anyone.
inline TlsContext client_context(int max_version = TLS1_3_VERSION) {
  TlsContext context(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free);
  SSL_CTX_set_max_proto_version(context.get(), max_version);
  return context;
}

inline TlsContext server_context(const Identity& identity, int max_version = TLS1_3_VERSION) {
  TlsContext context(SSL_CTX_new(TLS_server_method()), &SSL_CTX_free);
  SSL_CTX_set_max_proto_version(context.get(), max_version);
  use(context.get(), identity);
  return context;
}

/// An end of a connection; the caller owns the socket.
class TlsConnection {
 public:
  TlsConnection(SSL_CTX* context, int socket) : ssl_(SSL_new(context), &SSL_free) {
    std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to a closed connection
    SSL_set_fd(ssl_.get(), socket);
  }
  bool connect() { return SSL_connect(ssl_.get()) == 1; }
  bool accept() { return SSL_accept(ssl_.get()) == 1; }

  /// False if a part was not sent.
  bool write(std::span<const std::uint8_t> bytes) {
    return bytes.empty() || SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size())) ==
                                static_cast<int>(bytes.size());
  }
  /// Reads `size` bytes; fewer if the other side closed or sent nothing.
  std::vector<std::uint8_t> read(std::size_t size) {
    std::vector<std::uint8_t> bytes(size);
    std::size_t got = 0;
    while (got < size) {
      const int more = SSL_read(ssl_.get(), bytes.data() + got, static_cast<int>(size - got));
      if (more <= 0) break;
      got += static_cast<std::size_t>(more);
    }
    bytes.resize(got);
    return bytes;
  }
  SSL* native() const { return ssl_.get(); }

 private:
  std::unique_ptr<SSL, decltype(&SSL_free)> ssl_;
};

}  // namespace feltwire::test
