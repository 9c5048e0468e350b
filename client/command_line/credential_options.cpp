#include "client/command_line/credential_options.hpp"

#include <CLI/CLI.hpp>

namespace feltwire {

void add_credential_options(CLI::App& app, CredentialOptions& words,
                            const CredentialWording& wording) {
  const auto add = [&](const std::string& name, std::string& value, const std::string& text) {
    app.add_option("--" + name, value, text)->group(wording.group);
  };
  add("fingerprint", words.fingerprint,
      "Fingerprint of the server's certificate: 64 hex digits. feltwire-server prints it");
  add("fingerprint-file", words.fingerprint_file,
      "FILE with the fingerprint, for example `fingerprint` in the server's state folder");
  add("ca", words.ca,
      "FILE (PEM) of trusted authorities. One of them must have signed the server's certificate, "
      "and the certificate must name the host of --connect");
  add("token-file", words.token_file,
      std::string("FILE with ") + wording.token + ". Or set FELTWIRE_TOKEN in the environment");
  add(wording.prefix + "certificate", words.certificate,
      "FILE (PEM) of the client's certificate, for a server that requires client certificates");
  add(wording.prefix + "key", words.key, "FILE (PEM) of the key of the client's certificate");
}

Rivals credential_rivals() { return exclusive({"fingerprint", "fingerprint-file", "ca"}); }

std::vector<std::pair<std::string, std::string>> credential_variables(const std::string& prefix) {
  std::vector<std::pair<std::string, std::string>> variables;
  for (const char* option : {"connect", "fingerprint", "fingerprint-file", "ca", "token-file"})
    variables.emplace_back(option, in_capitals("FELTWIRE_", option));
  for (const char* option : {"certificate", "key"})
    variables.emplace_back(prefix + option, in_capitals("FELTWIRE_", option));
  return variables;
}

}  // namespace feltwire
