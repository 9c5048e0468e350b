#include "protocol/crypto/tls.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sodium.h>

#include <new>
#include <stdexcept>

namespace feltwire {

Fingerprint fingerprint(const x509_st& certificate) {
  Fingerprint result;
  unsigned size = 0;
  if (X509_digest(&certificate, EVP_sha256(), result.data(), &size) != 1 || size != result.size())
    throw std::runtime_error("cannot take a certificate's fingerprint: " + last_tls_error());
  return result;
}

std::string to_string(const Fingerprint& fingerprint) {
  std::string text(2 * fingerprint.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), fingerprint.data(), fingerprint.size());
  text.pop_back();
  return text;
}

Fingerprint parse_fingerprint(std::string_view text) {
  Fingerprint result;
  std::size_t size = 0;
  const char* end = nullptr;
  if (sodium_hex2bin(result.data(), result.size(), text.data(), text.size(), ":", &size, &end) !=
          0 ||
      size != result.size() || end != text.data() + text.size())
    throw std::invalid_argument(
        "'" + std::string(text) +
        "' is no fingerprint: 64 hex digits, the SHA-256 of the server's certificate; "
        "feltwire-server prints it at its start");
  return result;
}

ssl_ctx_st* new_tls_context(const ssl_method_st* method) {
  SSL_CTX* context = SSL_CTX_new(method);
  if (context == nullptr) throw std::bad_alloc();
  return context;
}

ssl_st* new_tls_connection(ssl_ctx_st& context) {
  SSL* connection = SSL_new(&context);
  if (connection == nullptr) throw std::bad_alloc();
  return connection;
}

void require_buffers(const ssl_st& connection) {
  if (SSL_get_rbio(&connection) == nullptr || SSL_get_wbio(&connection) == nullptr)
    throw std::bad_alloc();
}

void require_tls_13(ssl_ctx_st& context) {
  if (SSL_CTX_set_min_proto_version(&context, TLS1_3_VERSION) != 1 ||
      SSL_CTX_set_num_tickets(&context, 0) != 1)
    throw std::runtime_error("this machine cannot use TLS 1.3: " + last_tls_error());
  SSL_CTX_set_session_cache_mode(&context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_options(&context, SSL_OP_CLEANSE_PLAINTEXT);
}

bool has_aes_256_gcm() noexcept {
  return sodium_init() >= 0 && crypto_aead_aes256gcm_is_available() == 1;
}

std::string last_tls_error() {
  const unsigned long code = ERR_peek_last_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return reason == nullptr ? "no reason is known" : reason;
}

}  // namespace feltwire
