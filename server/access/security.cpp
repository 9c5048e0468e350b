#include "server/access/security.hpp"

#include <unistd.h>

#include <array>
#include <asio/buffer.hpp>
#include <asio/ip/address.hpp>
#include <asio/ssl/context.hpp>
#include <cstdint>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/base/json_document.hpp"
#include "core/base/pending_file.hpp"
#include "core/base/private_folder.hpp"
#include "core/base/state_folder.hpp"
#include "protocol/crypto/private_file.hpp"
#include "server/access/file_lock.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCertificate = "certificate.pem";
constexpr const char* kKey = "key.pem";
constexpr const char* kFingerprint = "fingerprint";
constexpr const char* kLocalToken = "local.token";

fs::path state_folder(const SecurityOptions& config) {
  if (config.state.empty()) return default_state_folder();
  // Remove a slash at the end of the path.
  return config.state.has_filename() ? config.state : config.state.parent_path();
}

bool needs_state(const SecurityOptions& config) {
  return !config.state.empty() || config.certificate.empty() || config.tokens.empty();
}

/// Throws FileError if others than the owner may write to the folder.
void check_folder(const fs::path& folder) {
  if (const auto open = open_folder(folder)) throw FileError(*open);
}

/// Makes the folder, with access for its owner only. Throws FileError if that fails, or if other
/// users may write to the folder.
void make_folder(const fs::path& folder) {
  if (const std::error_code failed = make_private_folder(folder))
    throw FileError(folder.string() + ": cannot be made: " + failed.message() +
                    "; choose another folder with --state");
  check_folder(folder);
}

/// Returns the names and addresses that clients may use for this server.
std::vector<std::string> own_names(const SecurityOptions& config) {
  std::vector<std::string> names = {"localhost", "127.0.0.1", "::1"};
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0 && host[0] != '\0') {
    const std::string name = host.data();
    if (name.find_first_not_of(
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-") ==
            std::string::npos &&
        name != "localhost")
      names.push_back(name);
  }
  const auto address = asio::ip::make_address(config.address);
  if (!address.is_unspecified() && !address.is_loopback()) names.push_back(address.to_string());
  return names;
}

/// A start makes the files that are missing; a renewal refuses.
enum class Missing : std::uint8_t { made, refused };

/// Loads the key and the certificate from the state folder. A start makes them if they are missing.
/// The key is written first, then the certificate, then (by open_security) the fingerprint. A key
/// without certificate and fingerprint shows that the first start was interrupted: both are made
/// again.
Identity own_identity(const SecurityOptions& config, const fs::path& folder, Missing missing) {
  const fs::path certificate = folder / kCertificate, key = folder / kKey;
  const bool has_certificate = fs::exists(certificate), has_key = fs::exists(key);
  const bool was_known = fs::exists(folder / kFingerprint);
  const bool is_first_start = !has_certificate && (!has_key || !was_known);
  if (is_first_start && missing == Missing::made) {
    const Identity made = make_identity(own_names(config));
    replace_file(key, made.key.text(), kPrivate);
    replace_file(certificate, made.certificate, kPublic);
  } else if (has_certificate != has_key) {
    const fs::path& lost = has_key ? certificate : key;
    const fs::path& there = has_key ? key : certificate;
    throw FileError(lost.string() + ": is missing; put it back, or remove " + there.string() +
                    " too: then both are made anew, and clients need the new fingerprint");
  }
  return load_identity(certificate, key);
}

/// Reads the authorities of the clients. Empty: clients need no certificate.
std::string read_authorities(const SecurityOptions& config) {
  if (config.client_ca.empty()) return {};
  std::string authorities = read_text(config.client_ca);
  // An empty text means that clients need no certificate, so an empty file must not pass for it.
  if (authorities.empty())
    throw FileError(config.client_ca.string() +
                    ": holds no authority's certificate (it is empty); give one in PEM");
  std::error_code wrong;
  asio::ssl::context(asio::ssl::context::tls_server)
      .add_certificate_authority(asio::buffer(authorities), wrong);
  if (wrong)
    throw FileError(config.client_ca.string() + ": holds no authority's certificate (" +
                    wrong.message() + "); give one in PEM");
  return authorities;
}

void write_fingerprint(const fs::path& folder, const Identity& identity) {
  const std::string print = to_string(fingerprint(identity)) + "\n";
  const fs::path file = folder / kFingerprint;
  if (!fs::exists(file) || read_text(file) != print) replace_file(file, print, kPublic);
}

/// Makes the first token, so that the user who starts the server can join. The text of the token is
/// written before tokens.json. If the start is interrupted between the two, the next start finds no
/// tokens.json and makes both again.
void make_tokens(const SecurityOptions& config) {
  const IssuedToken local = issue_token("local", "*", Role::operator_, std::nullopt);
  replace_file(local_token_file(config), local.text.text(), kPrivate);
  change_tokens(token_file(config), [&](Tokens& tokens) { tokens.push_back(local.token); });
}

/// Removes the temporary files of an interrupted start. Precondition: the caller holds the lock of
/// the folder.
void tidy(const SecurityOptions& config, const fs::path& folder) {
  for (const char* name : {kCertificate, kKey, kFingerprint, kLocalToken})
    remove_leftovers(folder / name);
  if (!config.tokens.empty()) return;
  const FileLock lock(token_file(config).string() + ".lock");
  remove_leftovers(token_file(config));
}

/// Checks and reads all files but the tokens, at the start and at each renewal.
RenewedFiles read_files(const SecurityOptions& config, Missing missing) {
  RenewedFiles files{.identity = {}, .client_authorities = read_authorities(config)};
  if (!needs_state(config)) {
    files.identity = load_identity(config.certificate, config.key);
    return files;
  }
  const bool makes = missing == Missing::made;
  const fs::path folder = state_folder(config);
  makes ? make_folder(folder) : check_folder(folder);
  const FileLock lock(folder / "lock");  // two servers may start at the same time
  if (makes) tidy(config, folder);
  files.identity = config.certificate.empty() ? own_identity(config, folder, missing)
                                              : load_identity(config.certificate, config.key);
  write_fingerprint(folder, files.identity);
  if (makes && config.tokens.empty() && !fs::exists(token_file(config))) make_tokens(config);
  return files;
}

}  // namespace

std::filesystem::path default_state_folder() {
  if (auto folder = user_state_folder()) return *std::move(folder);
  throw std::invalid_argument(
      "no folder for certificate and tokens: neither XDG_STATE_HOME nor HOME is set; name one with "
      "--state");
}

void make_state_folder(const SecurityOptions& config) {
  if (needs_state(config)) make_folder(state_folder(config));
}

std::filesystem::path token_file(const SecurityOptions& config) {
  return config.tokens.empty() ? state_folder(config) / "tokens.json" : config.tokens;
}

std::filesystem::path local_token_file(const SecurityOptions& config) {
  return needs_state(config) ? state_folder(config) / kLocalToken : fs::path();
}

void check_security(const SecurityOptions& config) {
  read_authorities(config);
  const fs::path folder = needs_state(config) ? state_folder(config) : fs::path();
  if (fs::exists(folder)) check_folder(folder);
  if (!config.certificate.empty())
    load_identity(config.certificate, config.key);
  else if (fs::exists(folder / kCertificate))
    load_identity(folder / kCertificate, folder / kKey);
  if (!config.tokens.empty() || fs::exists(token_file(config)))
    const TokenFile tokens(token_file(config));
}

RenewedFiles read_security_again(const SecurityOptions& config) {
  return read_files(config, Missing::refused);
}

Security open_security(const SecurityOptions& config) {
  RenewedFiles files = read_files(config, Missing::made);
  return {std::move(files.identity), std::move(files.client_authorities),
          TokenFile(token_file(config))};
}

}  // namespace feltwire
