#include "server/security.hpp"

#include <unistd.h>

#include <array>
#include <asio/ip/address.hpp>
#include <cstdlib>
#include <stdexcept>

#include "core/scene/json_document.hpp"
#include "server/state_file.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

fs::path state_folder(const ServerConfig& config) {
  return config.state.empty() ? default_state_folder() : config.state;
}

bool needs_state(const ServerConfig& config) {
  return !config.state.empty() || config.certificate.empty() || config.tokens.empty();
}

/// Who may read it may not write it; the key and the tokens are for the owner alone.
void make_folder(const fs::path& folder) {
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return;
  if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), failed);
  fs::create_directory(folder, failed);
  if (!failed) fs::permissions(folder, fs::perms::owner_all, failed);
  if (failed)
    throw FileError(folder.string() + ": cannot be made: " + failed.message() +
                    "; choose another folder with --state");
}

/// What clients may call this server by.
std::vector<std::string> own_names(const ServerConfig& config) {
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

Identity own_identity(const ServerConfig& config, const fs::path& folder) {
  const fs::path certificate = folder / "certificate.pem", key = folder / "key.pem";
  if (!fs::exists(certificate) && !fs::exists(key)) {
    const Identity made = make_identity(own_names(config));
    write_state(key, made.key.text(), kPrivate);
    write_state(certificate, made.certificate, kPublic);
  }
  return load_identity(certificate, key);
}

/// The first token, so that whoever starts a server can feel something.
void make_tokens(const ServerConfig& config) {
  const IssuedToken local = issue_token("local", "*", Role::operator_, std::nullopt);
  change_tokens(token_file(config), [&](Tokens& tokens) { tokens.push_back(local.token); });
  write_state(local_token_file(config), local.text.text(), kPrivate);
}

}  // namespace

std::filesystem::path default_state_folder() {
  if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state == '/')
    return fs::path(state) / "feltwire";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/')
    return fs::path(home) / ".local/state/feltwire";
  throw std::invalid_argument(
      "no folder for certificate and tokens: neither XDG_STATE_HOME nor HOME is set; name one with "
      "--state");
}

void make_state_folder(const ServerConfig& config) {
  if (needs_state(config)) make_folder(state_folder(config));
}

std::filesystem::path token_file(const ServerConfig& config) {
  return config.tokens.empty() ? state_folder(config) / "tokens.json" : config.tokens;
}

std::filesystem::path local_token_file(const ServerConfig& config) {
  return needs_state(config) ? state_folder(config) / "local.token" : fs::path();
}

Security open_security(const ServerConfig& config) {
  std::string authorities;
  if (!config.client_ca.empty()) authorities = read_text(config.client_ca);
  if (!needs_state(config))
    return {load_identity(config.certificate, config.key), authorities, TokenFile(config.tokens)};

  const fs::path folder = state_folder(config);
  make_folder(folder);
  const FileLock lock(folder / "lock");  // two servers may start at once
  Identity identity = config.certificate.empty() ? own_identity(config, folder)
                                                 : load_identity(config.certificate, config.key);
  const std::string print = to_string(fingerprint(identity)) + "\n";
  const fs::path print_file = folder / "fingerprint";
  if (!fs::exists(print_file) || read_text(print_file) != print)
    write_state(print_file, print, kPublic);
  if (config.tokens.empty() && !fs::exists(token_file(config))) make_tokens(config);
  return {std::move(identity), authorities, TokenFile(token_file(config))};
}

}  // namespace feltwire
