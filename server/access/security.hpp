#pragma once
// The identity of a server, and the tokens that let clients in.

#include <filesystem>
#include <string>

#include "server/access/identity.hpp"
#include "server/access/security_options.hpp"
#include "server/access/token_file.hpp"

namespace feltwire {

struct Security {
  Identity identity;
  std::string client_authorities;  // PEM: a client needs a certificate of theirs; empty: none
  TokenFile tokens;
};

/// $XDG_STATE_HOME/feltwire or ~/.local/state/feltwire. Throws std::invalid_argument where the
/// environment names neither.
std::filesystem::path default_state_folder();

/// Where the tokens stand that a server with these options goes by.
std::filesystem::path token_file(const SecurityOptions& config);
/// The token that the first start made, for programs of the same user.
std::filesystem::path local_token_file(const SecurityOptions& config);

/// Makes the state folder where one is needed and missing, for its owner alone. Throws FileError,
/// also where others than its owner may write to it.
void make_state_folder(const SecurityOptions& config);

/// Reads what the configuration names. What it does not name lies in the state folder, and is made
/// where it is missing: a certificate, and tokens with one for this machine's user in local.token;
/// the certificate's fingerprint is written there. With a certificate and a token file named and no
/// state folder, none is needed. Throws FileError, std::invalid_argument or std::runtime_error.
Security open_security(const SecurityOptions& config);

}  // namespace feltwire
