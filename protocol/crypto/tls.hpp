#pragma once
// Used by both ends of a control connection: the fingerprint of a certificate, and what they
// require of TLS.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

struct ssl_st;
struct ssl_ctx_st;
struct ssl_method_st;
struct x509_st;

namespace feltwire {

/// SHA-256 of a certificate (DER).
using Fingerprint = std::array<std::uint8_t, 32>;

/// Throws std::runtime_error.
Fingerprint fingerprint(const x509_st& certificate);
/// 64 hex digits.
std::string to_string(const Fingerprint& fingerprint);
/// Hex digits of either case, with or without colons. Throws std::invalid_argument.
Fingerprint parse_fingerprint(std::string_view text);

/// For Asio's ssl::context and ssl::stream, which take them over; std::bad_alloc where there is no
/// memory for them. Asio's own take a failure of OpenSSL that left no word of it, because there was
/// no memory for the word either, for success.
ssl_ctx_st* new_tls_context(const ssl_method_st* method);
ssl_st* new_tls_connection(ssl_ctx_st& context);
/// Checks that an ssl::stream was made from the connection in whole. Throws std::bad_alloc.
void require_buffers(const ssl_st& connection);

/// TLS 1.3 only, without tickets and early data: every connection has its own key exchange, so no
/// two connections share a key. OpenSSL wipes what it received once it has given it out, because
/// messages hold secrets.
void require_tls_13(ssl_ctx_st& context);

/// Whether this CPU has the instructions that make AES-256-GCM fast, and safe against timing
/// attacks.
bool has_aes_256_gcm() noexcept;

/// OpenSSL's text for the last failure in this thread, in one line.
std::string last_tls_error();

}  // namespace feltwire
