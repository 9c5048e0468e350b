#include "client/app/credential_options.hpp"

#include <CLI/CLI.hpp>

namespace feltwire {

void add_credential_options(CLI::App& app, CredentialOptions& words) {
  const auto group = "Trust (SECURITY.md)";
  app.add_option("--fingerprint", words.fingerprint,
                 "Of the server's certificate: 64 hex digits that feltwire-server prints")
      ->group(group);
  app.add_option("--fingerprint-file", words.fingerprint_file,
                 "FILE with it, e.g. `fingerprint` of the server's state folder")
      ->group(group);
  app.add_option("--ca", words.ca,
                 "FILE (PEM) of authorities; the server's certificate must be theirs, and for the "
                 "host in --connect")
      ->group(group);
  app.add_option("--token-file", words.token_file,
                 "FILE with the token to be let in by; or the environment's FELTWIRE_TOKEN")
      ->group(group);
  app.add_option("--certificate", words.certificate,
                 "FILE (PEM), for a server that asks its clients for one")
      ->group(group);
  app.add_option("--key", words.key, "FILE (PEM) of that certificate's key")->group(group);
}

}  // namespace feltwire
