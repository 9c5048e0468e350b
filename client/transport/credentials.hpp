#pragma once
// By what a client knows its server, and by what the server lets it in.

#include <string>
#include <variant>

#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/tls.hpp"

namespace feltwire {

/// Who may sign a server's certificate (PEM); it must be for the host that was asked for.
struct Authorities {
  std::string certificates;
};

struct Credentials {
  /// Which server is trusted: the one whose certificate has this fingerprint, whatever the
  /// certificate says, or one whose certificate these authorities signed.
  std::variant<Fingerprint, Authorities> trust;
  std::string certificate;  // PEM, for a server that asks its clients for one; else empty
  Secret key;               // of that certificate
  Secret token;
};

/// Credentials as options name them; empty: not given. To know the server: its fingerprint, a file
/// with the fingerprint, or a file (PEM) of authorities, one of the three. For a server that asks
/// for a client certificate: the files of the certificate and of its key. A file with the token.
struct CredentialOptions {
  std::string fingerprint, fingerprint_file, ca, certificate, key, token_file;
};

/// Reads the files. The token comes from its file or from the environment variable FELTWIRE_TOKEN.
/// Throws std::invalid_argument that names the option and the remedy.
Credentials credentials(const CredentialOptions& options);

}  // namespace feltwire
