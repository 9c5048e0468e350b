#pragma once
// Bearer tokens: the data that a server keeps of each, and the check of a text. It uses no file;
// only calendar_now() reads a clock.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/crypto/secret.hpp"
#include "protocol/session/lead_share.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {

/// The server's calendar time (UTC).
using CalendarTime = std::chrono::sys_seconds;
inline CalendarTime calendar_now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

struct Token {
  std::string id;           // 12 hex digits; no secret
  std::string client;       // name of its holder
  std::string scene = "*";  // the scene that it opens; *: any
  Role role = Role::observer;
  double lead_share = 0.0;  // of its hands, in a scene with a robot's seat
  std::string seat;         // for a follower: the only seat that it may take; empty: any
  std::optional<CalendarTime> expires;
  std::array<std::uint8_t, 16> salt{};
  std::array<std::uint8_t, 32> hash{};  // of the secret, keyed with the salt
};
using Tokens = std::vector<Token>;

bool opens(const Token& token, std::string_view scene);
bool expired(const Token& token, CalendarTime now);

/// Makes a new token, and the text for its holder: `fw_<id>_<secret>`, which is stored nowhere
/// else. Throws std::invalid_argument if a name is empty, too long, an access token or has control
/// characters, and for a share that does not exist or a role that leads no robot, or a seat for a
/// role that takes none.
struct IssuedToken {
  Token token;
  Secret text;
};
IssuedToken issue_token(std::string client, std::string scene, Role role,
                        std::optional<CalendarTime> expires, double lead_share = 0.0,
                        std::string seat = {});

/// Null if there is no token with that id.
const Token* find_token(const Tokens& tokens, std::string_view id);

/// Returns the token for `text`. Null for any other text and for an expired token. The time does
/// not depend on which part is wrong.
const Token* authenticate(const Tokens& tokens, std::string_view text, CalendarTime now);

/// Reads `30d`, `12h`, a day like `2026-12-31` (until its end, UTC) or `never` (nullopt), with
/// `now` as the beginning. Throws std::invalid_argument.
std::optional<CalendarTime> parse_expiry(std::string_view text, CalendarTime now);
/// `2026-12-31 23:59:59 UTC`, or `never`.
std::string expiry_text(const std::optional<CalendarTime>& expires);

/// Reads the token file's text (JSON against tokens.fbs). Throws FileError "file:line: field: what
/// is wrong; remedy".
Tokens parse_tokens(std::string_view json, const std::string& file);
/// Returns the text that parse_tokens() reads.
std::string json(const Tokens& tokens);

}  // namespace feltwire
