#pragma once
// A certificate and tokens for servers and clients in tests: made once per process, without files.

#include "client/transport/control_client.hpp"
#include "server/access/security.hpp"

namespace feltwire::test {

inline const Identity& identity() {
  static const Identity made = make_identity({"localhost", "127.0.0.1", "::1"});
  return made;
}

/// A token that permits everything.
inline const IssuedToken& admin_token() {
  static const IssuedToken issued = issue_token("tester", "*", Role::admin, std::nullopt);
  return issued;
}

/// The security of a server that knows admin_token() and `others`.
inline Security security(Tokens others = {}) {
  others.push_back(admin_token().token);
  return {identity(), {}, TokenFile(std::move(others))};
}

/// Credentials that trust identity() and show a token.
inline Credentials credentials(const Secret& token = admin_token().text) {
  return {fingerprint(identity()), {}, {}, token};
}

inline ServerAccess access(std::uint16_t port, const std::string& host = "127.0.0.1",
                           const Secret& token = admin_token().text) {
  return {{host, port}, credentials(token)};
}

}  // namespace feltwire::test
