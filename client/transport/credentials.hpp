#pragma once
// The credentials of a client, and how it recognises its server.

#include <string>
#include <variant>

#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/tls.hpp"

namespace feltwire {

/// Authorities (PEM) that may sign a server's certificate. The certificate must be for the host
/// that the client asked for.
struct Authorities {
  std::string certificates;
};

struct Credentials {
  /// The trusted server: the one whose certificate has this fingerprint, with any other contents
  /// of the certificate, or one whose certificate these authorities signed.
  std::variant<Fingerprint, Authorities> trust;
  std::string certificate;  // PEM, for a server that asks its clients for one; else empty
  Secret key;               // of that certificate
  Secret token;
};

/// The options with the credentials; an empty one is not given. One of three identifies the server:
/// its fingerprint, a file with the fingerprint, or a file (PEM) of authorities. A server that asks
/// for a client certificate needs the files of the certificate and of its key. The token is in a
/// file.
struct CredentialOptions {
  std::string fingerprint, fingerprint_file, ca, certificate, key, token_file;
};

/// Reads the files. The token comes from its file or from the environment variable FELTWIRE_TOKEN.
/// Throws std::invalid_argument that names the option and the remedy.
Credentials credentials(const CredentialOptions& options);

}  // namespace feltwire
