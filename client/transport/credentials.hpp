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
  /// The server's very certificate, whatever stands in it, or who signed it.
  std::variant<Fingerprint, Authorities> trust;
  std::string certificate;  // PEM, for a server that asks its clients for one; else empty
  Secret key;               // of that certificate
  Secret token;
};

/// The same as it is asked for: of the server one of a fingerprint, a file with it, and a file
/// (PEM) of authorities; for a server that asks for a certificate, its file and its key's; a file
/// with the token.
struct CredentialOptions {
  std::string fingerprint, fingerprint_file, ca, certificate, key, token_file;
};

/// Reads the files, and the token from its file or the environment's FELTWIRE_TOKEN. Throws
/// std::invalid_argument naming option and remedy.
Credentials credentials(const CredentialOptions& options);

}  // namespace feltwire
