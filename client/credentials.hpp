#pragma once
// By what a client knows its server, and by what the server lets it in.

#include <string>
#include <variant>

#include "protocol/secret.hpp"
#include "protocol/tls.hpp"

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

}  // namespace feltwire
