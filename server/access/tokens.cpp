#include "server/access/tokens.hpp"

#include <sodium.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "core/base/json_document.hpp"
#include "core/base/token_text.hpp"
#include "protocol/wire/control.hpp"
#include "server/access/json_text.hpp"
#include "server/access/tokens_generated.h"
#include "server/access/tokens_text.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kIdBytes = 6, kIdDigits = 2 * kIdBytes;
constexpr std::size_t kSecretBytes = 32;
constexpr int kBase64 = sodium_base64_VARIANT_URLSAFE_NO_PADDING;
constexpr std::size_t kSecretDigits = 43;  // length of 32 bytes in base64 without padding

using SecretBytes = std::array<std::uint8_t, kSecretBytes>;

/// Returns the salted hash of a secret. One round of a fast hash is enough, because the secret is
/// 256 random bits, not a password that could be guessed. Equal secrets have different hashes,
/// because each token has its own salt.
std::array<std::uint8_t, 32> hash_of(const SecretBytes& secret,
                                     const std::array<std::uint8_t, 16>& salt) {
  std::array<std::uint8_t, 32> hash;
  crypto_generichash(hash.data(), hash.size(), secret.data(), secret.size(), salt.data(),
                     salt.size());
  return hash;
}

void need_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
}

template <std::size_t N>
std::string hex(const std::array<std::uint8_t, N>& bytes) {
  std::string text(2 * N + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), N);
  text.pop_back();
  return text;
}

template <std::size_t N>
bool read_hex(std::string_view text, std::array<std::uint8_t, N>& bytes) {
  std::size_t size = 0;
  const char* end = nullptr;
  return text.size() == 2 * N &&
         sodium_hex2bin(bytes.data(), N, text.data(), text.size(), nullptr, &size, &end) == 0 &&
         size == N && end == text.data() + text.size();
}

/// Returns what is wrong with a name; empty if nothing is.
std::string complaint(std::string_view name) {
  const bool printable = std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (!name.empty() && name.size() <= control::kMaxName && printable) return {};
  return "must have 1 to " + std::to_string(control::kMaxName) +
         " bytes without control characters; choose another name";
}

/// Returns the reason why a token of this role cannot have this lead share (the weight of its hand
/// among hands that lead one robot). Empty if it can.
std::optional<std::string> complaint(Role role, double lead_share) {
  if (lead_share != 0.0 && !covers(role, Role::operator_))
    return "is for tokens of the roles operator and admin; leave it out";
  return wrong_lead_share(lead_share);
}

/// Returns the reason why a token of this role cannot be limited to this seat (the place of a robot
/// in a scene). Empty if it can.
std::string seat_complaint(Role role, std::string_view seat) {
  if (role != Role::follower) return "is for tokens of the role follower; leave it out";
  return complaint(seat);
}

/// The parts of a token's text, `fw_<id>_<secret>`.
struct Shown {
  std::string_view id;
  SecretBytes secret{};
  bool well_formed = false;
  ~Shown() { sodium_memzero(secret.data(), secret.size()); }
};

void read(std::string_view text, Shown& shown) {
  if (text.size() != kTokenPrefix.size() + kIdDigits + 1 + kSecretDigits ||
      !text.starts_with(kTokenPrefix) || text[kTokenPrefix.size() + kIdDigits] != '_')
    return;
  shown.id = text.substr(kTokenPrefix.size(), kIdDigits);
  const std::string_view secret = text.substr(text.size() - kSecretDigits);
  std::size_t size = 0;
  const char* end = nullptr;
  shown.well_formed = sodium_base642bin(shown.secret.data(), shown.secret.size(), secret.data(),
                                        secret.size(), nullptr, &size, &end, kBase64) == 0 &&
                      size == kSecretBytes && end == secret.data() + secret.size();
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() && read.ptr == text.data() + text.size();
}

}  // namespace

bool opens(const Token& token, std::string_view scene) {
  return token.scene == "*" || token.scene == scene;
}

bool expired(const Token& token, CalendarTime now) {
  return token.expires && now >= *token.expires;
}

IssuedToken issue_token(std::string client, std::string scene, Role role,
                        std::optional<CalendarTime> expires, double lead_share, std::string seat) {
  need_sodium();
  if (has_token(client) || has_token(scene))
    throw std::invalid_argument("a name is an access token, and names are shown; choose another");
  if (const std::string wrong = complaint(client); !wrong.empty())
    throw std::invalid_argument("the client's name " + wrong);
  if (const std::string wrong = complaint(scene); !wrong.empty())
    throw std::invalid_argument("the scene's name " + wrong);
  if (role == Role::follower && scene == "*")
    throw std::invalid_argument(
        "a token of the role follower is for the robot's seat of one scene; name the scene");
  if (const auto wrong = complaint(role, lead_share))
    throw std::invalid_argument("the lead share " + *wrong);
  if (!seat.empty())
    if (const std::string wrong = seat_complaint(role, seat); !wrong.empty())
      throw std::invalid_argument("the seat's name " + wrong);
  IssuedToken issued;
  Token& token = issued.token;
  token.client = std::move(client);
  token.scene = std::move(scene);
  token.role = role;
  token.lead_share = lead_share;
  token.seat = std::move(seat);
  token.expires = expires;
  std::array<std::uint8_t, kIdBytes> id;
  randombytes_buf(id.data(), id.size());
  token.id = hex(id);
  randombytes_buf(token.salt.data(), token.salt.size());
  SecretBytes secret;
  randombytes_buf(secret.data(), secret.size());
  token.hash = hash_of(secret, token.salt);

  std::string text(kSecretDigits + 1, '\0');
  sodium_bin2base64(text.data(), text.size(), secret.data(), secret.size(), kBase64);
  sodium_memzero(secret.data(), secret.size());
  text.pop_back();
  text.insert(0, std::string(kTokenPrefix) + token.id + "_");
  issued.text = Secret(text);
  wipe(text);
  return issued;
}

const Token* find_token(const Tokens& tokens, std::string_view id) {
  const auto found =
      std::find_if(tokens.begin(), tokens.end(), [&](const Token& t) { return t.id == id; });
  return found == tokens.end() ? nullptr : &*found;
}

const Token* authenticate(const Tokens& tokens, std::string_view text, CalendarTime now) {
  static const Token nobody;
  Shown shown;
  read(text, shown);
  const Token* found = find_token(tokens, shown.id);
  const Token& compared = found != nullptr ? *found : nobody;
  const auto hash = hash_of(shown.secret, compared.salt);
  const bool same = sodium_memcmp(hash.data(), compared.hash.data(), hash.size()) == 0;
  return found != nullptr && shown.well_formed && same && !expired(*found, now) ? found : nullptr;
}

std::optional<CalendarTime> parse_expiry(std::string_view text, CalendarTime now) {
  using namespace std::chrono;
  constexpr int kMost = 36'500;  // largest number of days or hours
  if (text == "never") return std::nullopt;
  int count = 0;
  if (text.size() > 1 && (text.back() == 'd' || text.back() == 'h') &&
      read_number(text.substr(0, text.size() - 1), count) && count > 0 && count <= kMost)
    return now + (text.back() == 'd' ? hours(24) : hours(1)) * count;
  constexpr std::size_t kDate = 10, kFirstDash = 4, kSecondDash = 7;
  int y = 0;
  unsigned m = 0, d = 0;
  if (text.size() == kDate && text[kFirstDash] == '-' && text[kSecondDash] == '-' &&
      read_number(text.substr(0, kFirstDash), y) &&
      read_number(text.substr(kFirstDash + 1, 2), m) &&
      read_number(text.substr(kSecondDash + 1), d)) {
    const year_month_day date{year(y), month(m), day(d)};
    if (date.ok() && sys_days(date) + days(1) > now) return sys_days(date) + days(1);
  }
  throw std::invalid_argument("'" + std::string(text) +
                              "' is no time to expire; write 30d, 12h, a day that is not over "
                              "like 2026-12-31, or never");
}

std::string expiry_text(const std::optional<CalendarTime>& expires) {
  using namespace std::chrono;
  if (!expires) return "never";
  const auto day = floor<days>(*expires);
  const year_month_day date(day);
  const hh_mm_ss time(*expires - day);
  std::array<char, 64> text;
  const int size = std::snprintf(
      text.data(), text.size(), "%04d-%02u-%02u %02d:%02d:%02d UTC", int{date.year()},
      unsigned{date.month()}, unsigned{date.day()}, static_cast<int>(time.hours().count()),
      static_cast<int>(time.minutes().count()), static_cast<int>(time.seconds().count()));
  return {text.data(), static_cast<std::size_t>(size)};
}

Tokens parse_tokens(std::string_view json, const std::string& file) {
  const JsonDocument document(json, file, embedded::tokens);
  const auto* root = flatbuffers::GetRoot<tokens_file::Tokens>(document.buffer());
  Tokens tokens;
  std::set<std::string> ids;
  for (const auto* entry : *root->tokens()) {
    const std::string path = "tokens[" + std::to_string(tokens.size()) + "].";
    Token token;
    std::array<std::uint8_t, kIdBytes> id;
    token.id = entry->id()->str();
    if (!read_hex(token.id, id) || hex(id) != token.id)
      document.fail(path + "id",
                    "must have 12 hex digits in lower case; make tokens with "
                    "feltwire-server token add");
    if (!ids.insert(token.id).second)
      document.fail(path + "id", "is that of another token, too; remove one of them");
    token.client = entry->client()->str();
    if (const std::string wrong = complaint(token.client); !wrong.empty())
      document.fail(path + "client", wrong);
    token.scene = entry->scene()->str();
    if (const std::string wrong = complaint(token.scene); !wrong.empty())
      document.fail(path + "scene", wrong);
    token.role = static_cast<Role>(entry->role());
    token.lead_share = entry->lead_share();
    if (const auto wrong = complaint(token.role, token.lead_share))
      document.fail(path + "lead_share", *wrong);
    if (const auto* seat = entry->seat()) {
      token.seat = seat->str();
      if (const std::string wrong = seat_complaint(token.role, token.seat); !wrong.empty())
        document.fail(path + "seat", wrong);
    }
    constexpr std::int64_t kLast = 253'402'300'800;  // [s] from 1970 to the year 10000
    if (entry->expires() < 0 || entry->expires() > kLast)
      document.fail(path + "expires", "must be seconds since 1970, or 0: never; correct it");
    if (entry->expires() > 0) token.expires = CalendarTime(std::chrono::seconds(entry->expires()));
    if (!read_hex(entry->salt()->string_view(), token.salt))
      document.fail(path + "salt", "must have 32 hex digits; revoke this token and make another");
    if (!read_hex(entry->hash()->string_view(), token.hash))
      document.fail(path + "hash", "must have 64 hex digits; revoke this token and make another");
    tokens.push_back(std::move(token));
  }
  return tokens;
}

std::string json(const Tokens& tokens) {
  using json_text::text;
  std::vector<std::string> list;
  list.reserve(tokens.size());
  for (const Token& token : tokens) {
    std::vector<json_text::Member> members = {
        {"id", text(token.id)},
        {"client", text(token.client)},
        {"scene", text(token.scene)},
        {"role", text(name(token.role))},
        {"lead_share", json_text::number(token.lead_share)},
        {"expires", json_text::number(std::int64_t{
                        token.expires ? token.expires->time_since_epoch().count() : 0})},
        {"salt", text(hex(token.salt))},
        {"hash", text(hex(token.hash))}};
    if (!token.seat.empty()) members.push_back({"seat", text(token.seat)});
    list.push_back(json_text::object(members));
  }
  return json_text::object({{"tokens", json_text::list(list)}}) + "\n";
}

}  // namespace feltwire
