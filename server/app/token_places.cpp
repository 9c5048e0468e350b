#include "server/app/token_places.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "server/access/security.hpp"
#include "server/app/fleet_wishes.hpp"
#include "server/fleet_host/fleet_tokens.hpp"

namespace feltwire {
namespace {

constexpr int kTries = 5;  // against hosts that write the same token

void add_to(Directory& directory, const Token& token) {
  if (entries_of(directory, Bucket::tokens).size() >= kMostFleetTokens)
    throw std::runtime_error("the fleet has " + std::to_string(kMostFleetTokens) +
                             " tokens, the most that hosts keep; give hosts tokens files of their "
                             "own");
  if (directory.compare_and_swap(Bucket::tokens, token.id, encode(token), 0).result !=
      WriteResult::written)
    throw std::runtime_error("the directory has not confirmed token " + token.id +
                             "; run token list --fleet, and token revoke --fleet if it is there");
}

bool revoke_in(Directory& directory, const std::string& id) {
  for (int i = 0; i < kTries; ++i) {
    const std::vector<DirectoryEntry> entries = entries_of(directory, Bucket::tokens);
    const auto entry = std::ranges::find(entries, id, &DirectoryEntry::key);
    const auto token = entry == entries.end() ? std::nullopt : decode_token(*entry);
    if (!token) return false;
    if (token->expires == revoked(*token).expires) return true;
    const WriteAnswer answer =
        directory.compare_and_swap(Bucket::tokens, id, encode(revoked(*token)), entry->revision);
    if (answer.result == WriteResult::written) return true;
  }
  throw std::runtime_error("the directory has not confirmed that token " + id +
                           " is revoked; run token list --fleet, and revoke it again");
}

Tokens list_of(Directory& directory) {
  Tokens tokens;
  for (const DirectoryEntry& entry : entries_of(directory, Bucket::tokens))
    if (auto token = decode_token(entry)) tokens.push_back(*std::move(token));
  return tokens;
}

}  // namespace

TokenPlace file_of_tokens(const ServerConfig& config) {
  const std::filesystem::path file = token_file(config);
  return {.add =
              [file](const Token& token) {
                change_tokens(file, [&](Tokens& tokens) { tokens.push_back(token); });
              },
          .revoke =
              [file](const std::string& id) {
                std::size_t count = 0;
                change_tokens(file, [&](Tokens& tokens) {
                  count = std::erase_if(tokens, [&](const Token& token) { return token.id == id; });
                });
                return count > 0;
              },
          .list = [file] { return TokenFile(file).tokens(); },
          .name = file.string()};
}

TokenPlace fleet_of_tokens(const std::shared_ptr<Directory>& directory) {
  return {.add = [directory](const Token& token) { add_to(*directory, token); },
          .revoke = [directory](const std::string& id) { return revoke_in(*directory, id); },
          .list = [directory] { return list_of(*directory); },
          .name = "the fleet"};
}

}  // namespace feltwire
