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
  std::string client_authorities;  // PEM: a client needs a certificate of one of them; empty: none
  TokenFile tokens;
};

/// Returns $XDG_STATE_HOME/feltwire or ~/.local/state/feltwire. Throws std::invalid_argument if the
/// environment has neither.
std::filesystem::path default_state_folder();

/// Returns the token file of a server with these options.
std::filesystem::path token_file(const SecurityOptions& config);
/// Returns the file with the token of the first start, for programs of the same user.
std::filesystem::path local_token_file(const SecurityOptions& config);

/// Creates the state folder with mode 0700 if it is needed and missing. Throws FileError, also if
/// others than its owner may write to it.
void make_state_folder(const SecurityOptions& config);

/// Reads the files of open_security() that exist, and writes none. Throws FileError with the first
/// that is wrong.
void check_security(const SecurityOptions& config);

/// The files of a server that a renewal reads again.
struct RenewedFiles {
  Identity identity;
  std::string client_authorities;  // as in Security
};

/// Reads the files again that open_security() read or made, except the tokens, after the same
/// checks, and writes the fingerprint of a new certificate. Creates nothing else. Throws FileError.
RenewedFiles read_security_again(const SecurityOptions& config);

/// Reads the configured files. Other files are in the state folder, and missing ones are created: a
/// certificate, and tokens with one for this machine's user in local.token. The certificate's
/// fingerprint is written there. If certificate and token file are configured without a state
/// folder, none is needed. Throws FileError, std::invalid_argument or std::runtime_error.
Security open_security(const SecurityOptions& config);

}  // namespace feltwire
