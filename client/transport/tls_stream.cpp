#include "client/transport/tls_stream.hpp"

#include <openssl/x509v3.h>

#include <algorithm>
#include <asio/connect.hpp>
#include <asio/read.hpp>
#include <asio/ssl/error.hpp>
#include <asio/write.hpp>

#include "core/base/cancellation.hpp"
#include "protocol/net/link_local.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;
using Error = std::error_code;

constexpr std::chrono::milliseconds kBetweenLooks{50};  // two looks whether the work is cancelled

bool work_is_cancelled() noexcept {
  return current_work() != nullptr && current_work()->cancelled();
}

/// Compares the certificate with the pinned fingerprint, in place of OpenSSL's check. Returns 1 if
/// they match, else 0.
int is_pinned(X509_STORE_CTX* judged, void* pin_of_stream) {
  auto& pin = *static_cast<TlsStream::Pin*>(pin_of_stream);
  const X509* certificate = X509_STORE_CTX_get0_cert(judged);
  try {
    if (certificate != nullptr) pin.seen = fingerprint(*certificate);
  } catch (...) {  // no fingerprint means no match; an exception must not pass through OpenSSL
  }
  if (pin.seen && pin.seen == pin.wanted) return 1;
  X509_STORE_CTX_set_error(judged, X509_V_ERR_CERT_REJECTED);
  return 0;
}

/// Returns the TLS context. Throws SessionError, not LastingError, because the failure may be
/// temporary: at a reconnection the call has succeeded before, so only memory can be missing.
asio::ssl::context client_context(const Credentials& credentials, TlsStream::Pin& pin) {
  asio::ssl::context tls(new_tls_context(TLS_client_method()));
  try {
    require_tls_13(*tls.native_handle());
    tls.set_verify_mode(asio::ssl::verify_peer);
    if (const auto* pinned = std::get_if<Fingerprint>(&credentials.trust)) {
      pin.wanted = *pinned;
      SSL_CTX_set_cert_verify_callback(tls.native_handle(), is_pinned, &pin);
    } else {
      tls.add_certificate_authority(
          asio::buffer(std::get<Authorities>(credentials.trust).certificates));
    }
    if (!credentials.certificate.empty()) {
      tls.use_certificate_chain(asio::buffer(credentials.certificate));
      const std::string_view key = credentials.key.text();
      tls.use_private_key(asio::buffer(key.data(), key.size()), asio::ssl::context::pem);
    }
  } catch (const std::exception& error) {
    throw SessionError(std::string("the certificates that were given cannot be used: ") +
                       error.what() + "; see --ca, --certificate and --key");
  }
  return tls;
}

/// Throws LastingError if the server refused this client's certificate.
void fail_for_own_certificate(const std::string& server, int reason) {
  switch (reason) {
    case SSL_R_TLSV13_ALERT_CERTIFICATE_REQUIRED:
      throw LastingError(server +
                         " asks its clients for a certificate; give --certificate and --key");
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_UNSUPPORTED_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_REVOKED:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
      throw LastingError(server +
                         " does not take the certificate in --certificate; have one made by an "
                         "authority that it knows, and see that it has not expired");
    default:
      return;
  }
}

/// Requires a certificate for this host, without partial wildcards.
void expect_host(SSL* connection, const std::string& host) {
  X509_VERIFY_PARAM* parameters = SSL_get0_param(connection);
  X509_VERIFY_PARAM_set_hostflags(parameters, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
  Error no_address;
  asio::ip::make_address(host, no_address);
  // Remove the zone of an IPv6 address. It is local to this machine and in no certificate.
  const std::string address = host.substr(0, host.find('%'));
  const int set = no_address ? X509_VERIFY_PARAM_set1_host(parameters, host.c_str(), host.size())
                             : X509_VERIFY_PARAM_set1_ip_asc(parameters, address.c_str());
  if (set != 1) throw SessionError("no certificate can have the host name '" + host + "'");
}

/// Looks up the host. This can take many seconds, and nothing can cancel it.
tcp::resolver::results_type addresses_of(const Endpoint& server, asio::io_context& io) {
  Error error;
  tcp::resolver resolver(io);
  auto found = resolver.resolve(server.host, std::to_string(server.port), error);
  check_cancelled();
  if (error)
    throw SessionError("cannot find host '" + server.host + "': " + error.message() +
                       (server.host.find('%') == std::string::npos
                            ? "; check the name in --connect"
                            : "; check the address in --connect, and that the zone behind its % is "
                              "the name of an interface of this machine"));
  for (const auto& entry : found)
    if (const auto wrong = missing_zone(entry.endpoint().address()))
      throw LastingError("cannot connect to " + to_string(server) + ": " + *wrong);
  return found;
}

}  // namespace

TlsStream::TlsStream(const ServerAccess& server, std::chrono::milliseconds timeout)
    : server_(to_string(server.endpoint)),
      timeout_(timeout),
      found_(addresses_of(server.endpoint, io_)),
      tls_(client_context(server.credentials, pin_)),
      stream_(io_, new_tls_connection(*tls_.native_handle())) {
  require_buffers(*stream_.native_handle());
  connect();
  handshake(server);
}

void TlsStream::connect() {
  await(
      [&](auto done) {
        asio::async_connect(stream_.lowest_layer(), found_,
                            [done](const Error& e, const tcp::endpoint&) { done(e); });
      },
      "cannot connect to ",
      "; is feltwire-server running there, and is the port its control port?");
  // Send small packets without delay. Otherwise the request waits 40 ms for an acknowledgement.
  Error error;
  stream_.lowest_layer().set_option(tcp::no_delay(true), error);
}

void TlsStream::handshake(const ServerAccess& server) {
  SSL* connection = stream_.native_handle();
  const bool pins = std::holds_alternative<Fingerprint>(server.credentials.trust);
  Error not_a_name;
  asio::ip::make_address(server.endpoint.host, not_a_name);
  if (not_a_name) SSL_set_tlsext_host_name(connection, server.endpoint.host.c_str());
  if (!pins) expect_host(connection, server.endpoint.host);
  try {
    await(
        [&](auto done) {
          stream_.async_handshake(asio::ssl::stream_base::client,
                                  [done](const Error& e) { done(e); });
        },
        "no TLS with ", "; is the port the control port of a feltwire-server?");
  } catch (const SessionError&) {
    const long verdict = SSL_get_verify_result(connection);
    // If no fingerprint could be computed, for example for lack of memory, the server is unknown.
    if (verdict == X509_V_OK || verdict == X509_V_ERR_OUT_OF_MEM || (pins && !pin_.seen)) throw;
    if (pins)
      throw LastingError(
          server_ + " is not the server whose fingerprint was given: its certificate's is " +
          to_string(*pin_.seen) +
          "; if it has a new certificate ask its owner for the fingerprint, else somebody stands "
          "in between");
    throw LastingError(server_ + " cannot be trusted: " + X509_verify_cert_error_string(verdict) +
                       "; check --ca, and that the certificate is for the host in --connect");
  }
}

void TlsStream::write(std::span<const std::uint8_t> bytes) {
  await(
      [&](auto done) {
        asio::async_write(stream_, asio::buffer(bytes.data(), bytes.size()),
                          [done](const Error& e, std::size_t) { done(e); });
      },
      "no answer from ", "; is the port the control port of a feltwire-server?");
}

void TlsStream::read(std::span<std::uint8_t> bytes) {
  await(
      [&](auto done) {
        asio::async_read(stream_, asio::buffer(bytes.data(), bytes.size()),
                         [done](const Error& e, std::size_t) { done(e); });
      },
      "no answer from ", "; is the port the control port of a feltwire-server?");
}

template <class Start>
void TlsStream::await(Start start, const std::string& what, const std::string& remedy) {
  Error result = asio::error::would_block;
  start([&result](const Error& error) { result = error; });
  io_.restart();
  const auto latest = std::chrono::steady_clock::now() + timeout_;
  while (!io_.stopped() && std::chrono::steady_clock::now() < latest && !work_is_cancelled())
    io_.run_until(std::min(latest, std::chrono::steady_clock::now() + kBetweenLooks));
  if (result == asio::error::would_block) {
    Error ignored;
    // close() aborts the operation, which then no longer uses `result`.
    stream_.lowest_layer().close(ignored);
    io_.restart();
    io_.run();
    check_cancelled();
    throw NoAnswer(what + server_ + " within " + std::to_string(timeout_.count()) + " ms" + remedy);
  }
  if (!result) return;
  // In TLS 1.3 the server checks the client's certificate after the client's part of the handshake.
  if (result.category() == asio::error::get_ssl_category())
    fail_for_own_certificate(server_, ERR_GET_REASON(static_cast<unsigned long>(result.value())));
  throw NoAnswer(what + server_ + ": " + result.message() + remedy);
}

}  // namespace feltwire
