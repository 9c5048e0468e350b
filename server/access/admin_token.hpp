#pragma once
// A token with which the user of the server's machine opens the live page as an admin.

#include <filesystem>

#include "server/access/security_options.hpp"

namespace feltwire {

/// Returns the file with that token; empty: the tokens are not those of the state folder
/// (`--tokens`), whose owner makes them.
std::filesystem::path admin_token_file(const SecurityOptions& config);

/// Makes the token and its file with mode 0600, unless the file is there already: a token that was
/// revoked is not made anew. Precondition: open_security(config) made the state folder. Throws
/// FileError.
void make_admin_token(const SecurityOptions& config);

}  // namespace feltwire
