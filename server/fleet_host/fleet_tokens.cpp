#include "server/fleet_host/fleet_tokens.hpp"

#include <utility>

#include "core/base/file_error.hpp"
#include "core/base/pending_file.hpp"
#include "server/access/token_file.hpp"

namespace feltwire {
namespace {

/// Whether a is an earlier end of the validity than b; no end is the latest.
bool earlier(const std::optional<CalendarTime>& a, const std::optional<CalendarTime>& b) {
  return a && (!b || *a < *b);
}

}  // namespace

std::string encode(const Token& token) { return json(Tokens{token}); }

std::optional<Token> decode_token(const DirectoryEntry& entry) try {
  Tokens tokens = parse_tokens(entry.value, entry.key);
  if (tokens.size() != 1 || tokens.front().id != entry.key) return std::nullopt;
  return std::move(tokens.front());
} catch (const FileError&) {
  return std::nullopt;
}

Token revoked(Token token) {
  token.expires = CalendarTime(std::chrono::seconds(1));
  return token;
}

FleetTokens::FleetTokens(std::filesystem::path file) : file_(std::move(file)) {
  if (!std::filesystem::exists(file_)) return;
  const TokenFile kept(file_);
  for (const Token& token : kept.tokens()) tokens_.emplace(token.id, token);
}

void FleetTokens::see(const DirectoryEntry& entry) {
  const std::optional<Token> token = decode_token(entry);
  if (!token) return;
  const auto known = tokens_.find(token->id);
  if (known != tokens_.end()) {
    if (!earlier(token->expires, known->second.expires)) return;
    known->second.expires = token->expires;
  } else if (tokens_.size() < kMostFleetTokens) {
    tokens_.emplace(token->id, *token);
  } else {
    return;
  }
  changed_ = true;
}

void FleetTokens::save() {
  Tokens tokens;
  for (const auto& [id, token] : tokens_) tokens.push_back(token);
  replace_file(file_, json(tokens), kPrivate);
  changed_ = false;
}

std::vector<FleetTokens::Write> FleetTokens::missing(
    const std::vector<DirectoryEntry>& listed) const {
  std::map<std::string, const DirectoryEntry*> there;
  for (const DirectoryEntry& entry : listed) there.emplace(entry.key, &entry);
  std::vector<Write> writes;
  for (const auto& [id, token] : tokens_) {
    const auto entry = there.find(id);
    if (entry == there.end()) {
      writes.push_back({id, encode(token), 0});
      continue;
    }
    const std::optional<Token> known = decode_token(*entry->second);
    if (known && !earlier(token.expires, known->expires)) continue;
    writes.push_back({id, encode(token), entry->second->revision});
  }
  return writes;
}

}  // namespace feltwire
