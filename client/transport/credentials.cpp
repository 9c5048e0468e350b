#include "client/transport/credentials.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "client/transport/control_client.hpp"
#include "core/base/file_error.hpp"
#include "core/base/regular_file.hpp"
#include "core/base/visible_text.hpp"
#include "protocol/crypto/private_file.hpp"

namespace feltwire {
namespace {

constexpr const char* kTokenVariable = "FELTWIRE_TOKEN";

std::string read_file(const std::string& name, const char* option) {
  // [bytes] Largest file. A system's list of certificate authorities has 0.3 MB.
  constexpr std::size_t kLargest = std::size_t{4} << 20;
  std::string text;
  try {
    text = read_regular_file(name, kLargest, "check the path and your right to read it");
  } catch (const FileError& error) {
    throw std::invalid_argument(std::string(option) + ": " + error.what());
  }
  if (text.empty())
    throw std::invalid_argument(std::string(option) + ": " + name + ": is empty; check the path");
  return text;
}

std::string first_word(const std::string& text) {
  constexpr const char* kSpace = " \t\r\n";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_first_of(kSpace, begin) - begin);
}

Secret read_secret(const std::string& name, const char* option, bool word) {
  std::string text = read_file(name, option);
  std::string wanted = word ? first_word(text) : text;
  Secret secret(wanted);
  wipe(text);
  wipe(wanted);
  return secret;
}

std::variant<Fingerprint, Authorities> trust(const CredentialOptions& words) {
  const int given = int{!words.fingerprint.empty()} + int{!words.fingerprint_file.empty()} +
                    int{!words.ca.empty()};
  if (given == 0)
    throw std::invalid_argument(
        "no option names the server to trust; give the --fingerprint that feltwire-server prints "
        "at its start, its --fingerprint-file, or --ca FILE where an authority signed its "
        "certificate");
  if (given > 1)
    throw std::invalid_argument(
        "--fingerprint, --fingerprint-file and --ca are three ways to say whom to trust; give one "
        "(if "
        "none is on the command line, set one of FELTWIRE_FINGERPRINT, FELTWIRE_FINGERPRINT_FILE "
        "and FELTWIRE_CA)");
  if (!words.ca.empty()) return Authorities{read_file(words.ca, "--ca")};
  return parse_fingerprint(words.fingerprint.empty()
                               ? first_word(read_file(words.fingerprint_file, "--fingerprint-file"))
                               : words.fingerprint);
}

Secret token(const CredentialOptions& words) {
  if (!words.token_file.empty()) {
    // Only warn: a token can be revoked, and containers often provide readable files.
    if (const auto open = exposure(words.token_file))
      std::fprintf(stderr, "%s: warning: --token-file: %s\n", program_invocation_short_name,
                   visible(*open).c_str());
    return read_secret(words.token_file, "--token-file", true);
  }
  // The token is no command line option, because every user of a machine can read command lines.
  if (const char* text = std::getenv(kTokenVariable); text != nullptr && *text != '\0')
    return Secret(text);
  throw std::invalid_argument(
      "no token to be let in by; give --token-file FILE or the environment FELTWIRE_TOKEN "
      "(feltwire-server token add makes one)");
}

}  // namespace

Credentials credentials(const CredentialOptions& words) {
  if (words.certificate.empty() != words.key.empty())
    throw std::invalid_argument("--certificate and --key go together; give both, or neither");
  Credentials result{trust(words), {}, {}, token(words)};
  if (!words.certificate.empty()) {
    result.certificate = read_file(words.certificate, "--certificate");
    if (const auto open = exposure(words.key)) throw std::invalid_argument("--key: " + *open);
    result.key = read_secret(words.key, "--key", false);
  }
  return result;
}

ServerAccess access_from_environment(std::string_view server) {
  const auto variable = [](const char* name) {
    const char* text = std::getenv(name);
    return std::string(text != nullptr ? text : "");
  };
  CredentialOptions options;
  options.fingerprint = variable("FELTWIRE_FINGERPRINT");
  options.fingerprint_file = variable("FELTWIRE_FINGERPRINT_FILE");
  options.ca = variable("FELTWIRE_CA");
  options.token_file = variable("FELTWIRE_TOKEN_FILE");
  options.certificate = variable("FELTWIRE_CERTIFICATE");
  options.key = variable("FELTWIRE_KEY");
  return {parse_endpoint(server), credentials(options)};
}

}  // namespace feltwire
