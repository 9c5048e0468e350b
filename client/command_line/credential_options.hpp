#pragma once
// The options of a program that name the trusted server and the client's credentials.

#include <string>
#include <utility>
#include <vector>

#include "client/transport/credentials.hpp"
#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// The texts of --help that differ between programs.
struct CredentialWording {
  const char* group = "Trust (SECURITY.md)";
  const char* token = "the token";  // the contents of --token-file's FILE
  std::string
      prefix;  // before `certificate` and `key`, for programs with a certificate of their own
};

void add_credential_options(CLI::App& app, CredentialOptions& words,
                            const CredentialWording& wording = {});

/// The three options that say whom to trust exclude each other.
Rivals credential_rivals();

/// The variables of --connect and of the options that add_credential_options() adds. `prefix` as
/// in CredentialWording. They are the same for every program that joins a server.
std::vector<std::pair<std::string, std::string>> credential_variables(
    const std::string& prefix = {});

}  // namespace feltwire
