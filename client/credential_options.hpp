#pragma once
// The part of the command line that says whom to trust and who one is.

#include <string>

#include "client/credentials.hpp"

namespace CLI {
class App;
}

namespace feltwire {

/// As written, before the files are read.
struct CredentialWords {
  std::string fingerprint, fingerprint_file, ca, certificate, key, token_file;
};

void add_credential_options(CLI::App& app, CredentialWords& words);

/// Reads the files, and the token from its file or the environment's FELTWIRE_TOKEN. Throws
/// std::invalid_argument naming option and remedy.
Credentials credentials(const CredentialWords& words);

}  // namespace feltwire
