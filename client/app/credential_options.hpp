#pragma once
// The part of the command line that says whom to trust and who one is.

#include "client/transport/credentials.hpp"

namespace CLI {
class App;
}

namespace feltwire {

void add_credential_options(CLI::App& app, CredentialOptions& words);

}  // namespace feltwire
