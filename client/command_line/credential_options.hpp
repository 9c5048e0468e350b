#pragma once
// The part of a program's command line that says whom to trust and who one is.

#include <string>

#include "client/transport/credentials.hpp"

namespace CLI {
class App;
}

namespace feltwire {

/// The texts of --help that differ between programs.
struct CredentialWording {
  const char* group = "Trust (SECURITY.md)";
  const char* token = "the token";  // what --token-file's FILE has
  std::string prefix;  // before `certificate` and `key`, in programs that have a certificate too
};

void add_credential_options(CLI::App& app, CredentialOptions& words,
                            const CredentialWording& wording = {});

}  // namespace feltwire
