#pragma once
// The options of a program that name the trusted server and the client's credentials.

#include <string>

#include "client/transport/credentials.hpp"
#include "core/command_line/environment.hpp"

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

}  // namespace feltwire
