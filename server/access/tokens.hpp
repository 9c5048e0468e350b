#pragma once
// Bearer tokens: what a server knows of each, and whether a text is one of them. No file; only
// calendar_now() reads a clock.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/crypto/secret.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {

/// The server's calendar time (UTC).
using CalendarTime = std::chrono::sys_seconds;
inline CalendarTime calendar_now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

struct Token {
  std::string id;           // 12 hex digits; no secret
  std::string client;       // whom it was given to
  std::string scene = "*";  // that it opens, *: any
  Role role = Role::observer;
  std::optional<CalendarTime> expires;
  std::array<std::uint8_t, 16> salt{};
  std::array<std::uint8_t, 32> hash{};  // of the secret, keyed with the salt
};
using Tokens = std::vector<Token>;

bool opens(const Token& token, std::string_view scene);
bool expired(const Token& token, CalendarTime now);

/// A new token, and the text that its holder shows: `fw_<id>_<secret>`, which stands nowhere else.
/// Throws std::invalid_argument when a name is empty, too long or has control characters.
struct IssuedToken {
  Token token;
  Secret text;
};
IssuedToken issue_token(std::string client, std::string scene, Role role,
                        std::optional<CalendarTime> expires);

/// Null when there is none of that id.
const Token* find_token(const Tokens& tokens, std::string_view id);

/// The token that `text` is, null for any other text and when it has expired. Takes the same time
/// whatever of it is wrong.
const Token* authenticate(const Tokens& tokens, std::string_view text, CalendarTime now);

/// Reads `30d`, `12h`, a day like `2026-12-31` (until its end, UTC) or `never` (nullopt), `now`
/// being the beginning. Throws std::invalid_argument.
std::optional<CalendarTime> parse_expiry(std::string_view text, CalendarTime now);
/// `2026-12-31 23:59:59 UTC`, or `never`.
std::string expiry_text(const std::optional<CalendarTime>& expires);

/// Reads the token file's text (JSON against tokens.fbs). Throws FileError "file:line: field: what
/// is wrong; remedy".
Tokens parse_tokens(std::string_view json, const std::string& file);
/// The text that parse_tokens() reads.
std::string json(const Tokens& tokens);

}  // namespace feltwire
