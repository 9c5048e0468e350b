#include "server/fleet_host/key_file.hpp"

#include <sodium.h>

#include <array>
#include <sstream>
#include <string>
#include <system_error>

#include "core/base/file_error.hpp"
#include "core/base/pending_file.hpp"
#include "core/base/regular_file.hpp"
#include "protocol/crypto/private_file.hpp"
#include "protocol/crypto/secret.hpp"

namespace feltwire {
namespace {

using Seed = std::array<std::uint8_t, paseto::kSeedSize>;
constexpr std::size_t kMostKeys = 2;

/// Reads one line: the seed in hex.
paseto::SigningKey parse_key(const std::filesystem::path& file, const std::string& line) {
  Seed seed{};
  std::size_t size = 0;
  const bool right = line.size() == 2 * seed.size() &&
                     sodium_hex2bin(seed.data(), seed.size(), line.data(), line.size(), nullptr,
                                    &size, nullptr) == 0 &&
                     size == seed.size();
  if (!right)
    throw FileError(file.string() +
                    ": is no file of ticket keys; remove it, and the server makes another");
  paseto::SigningKey key(seed);
  sodium_memzero(seed.data(), seed.size());
  return key;
}

}  // namespace

std::vector<paseto::SigningKey> ticket_keys(const std::filesystem::path& file) {
  std::error_code failed;
  if (!std::filesystem::exists(file, failed)) {
    std::vector<paseto::SigningKey> made{paseto::SigningKey::random()};
    write_ticket_keys(file, made);
    return made;
  }
  if (const auto open = exposure(file)) throw FileError(*open);
  constexpr std::size_t kLargest = 4096;  // [bytes]
  std::string text = read_regular_file(file, kLargest);
  std::vector<paseto::SigningKey> keys;
  std::istringstream lines(text);
  for (std::string line; keys.size() < kMostKeys && std::getline(lines, line); wipe(line))
    keys.push_back(parse_key(file, line));
  wipe(text);
  if (keys.empty()) parse_key(file, {});
  return keys;
}

void write_ticket_keys(const std::filesystem::path& file,
                       const std::vector<paseto::SigningKey>& keys) {
  std::string text;
  for (const paseto::SigningKey& key : keys) {
    std::array<char, 2 * paseto::kSeedSize + 1> hex;
    // The secret begins with its seed.
    sodium_bin2hex(hex.data(), hex.size(), key.secret().data(), paseto::kSeedSize);
    text.append(hex.data()).append("\n");
    sodium_memzero(hex.data(), hex.size());
  }
  replace_file(file, text, kPrivate);
  wipe(text);
}

}  // namespace feltwire
