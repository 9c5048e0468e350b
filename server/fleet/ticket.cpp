#include "server/fleet/ticket.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/base/utf8.hpp"
#include "server/access/json_text.hpp"
#include "server/fleet/ticket_generated.h"
#include "server/fleet/ticket_text.hpp"

namespace feltwire {
namespace {

/// Signed with every ticket, so that no text that a host signs for another purpose is a ticket.
constexpr std::string_view kPurpose = "feltwire ticket 1";
constexpr std::size_t kMaxTicketName = 128;  // [bytes]
constexpr std::array<std::string_view, 10> kRefusalNames = {
    "malformed",   "unknown key", "forged", "wrong scene", "wrong host",
    "wrong epoch", "expired",     "early",  "used",        "too many"};

std::string footer_of(const paseto::PublicKey& key) {
  return "{\"kid\":\"" + paseto::key_id(key) + "\"}";
}

/// RFC 3339, in UTC: 2026-11-30T10:00:00Z.
std::string rfc3339(std::chrono::sys_seconds time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ",
                static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()), static_cast<int>(clock.hours().count()),
                static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()));
  return text.data();
}

/// Reads what rfc3339() writes, and nothing else.
std::optional<std::chrono::sys_seconds> parse_rfc3339(const std::string& text) {
  int year = 0, hour = 0, minute = 0, second = 0;
  unsigned month = 0, day = 0;
  if (std::sscanf(text.c_str(), "%4d-%2u-%2uT%2d:%2d:%2dZ", &year, &month, &day, &hour, &minute,
                  &second) != 6)
    return std::nullopt;
  const auto date = std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day);
  if (!date.ok()) return std::nullopt;
  const std::chrono::sys_seconds time = std::chrono::sys_days(date) + std::chrono::hours(hour) +
                                        std::chrono::minutes(minute) + std::chrono::seconds(second);
  if (rfc3339(time) != text) return std::nullopt;
  return time;
}

std::string hex(const ReplayCache::Nonce& nonce) {
  std::array<char, 2 * std::tuple_size_v<ReplayCache::Nonce> + 1> text;
  return sodium_bin2hex(text.data(), text.size(), nonce.data(), nonce.size());
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxTicketName && is_utf8(text);
}

/// Reads a payload that a host of the fleet has signed.
std::optional<Ticket> read_payload(const std::string& payload) {
  try {
    const JsonDocument document(payload, "ticket", embedded::ticket);
    const auto* const read = flatbuffers::GetRoot<ticket_text::Ticket>(document.buffer());
    Ticket ticket{read->scene()->str(),
                  read->client()->str(),
                  static_cast<Role>(read->role()),
                  read->host()->str(),
                  {read->term(), read->holder()},
                  {},
                  {}};
    const auto issued = parse_rfc3339(read->iat()->str());
    const auto expires = parse_rfc3339(read->exp()->str());
    std::size_t size = 0;
    const std::string nonce = read->jti()->str();
    if (!is_name(ticket.scene) || !is_name(ticket.client) || !is_name(ticket.host) || !issued ||
        expires != *issued + kTicketLifetime || nonce.size() != 2 * ticket.nonce.size() ||
        sodium_hex2bin(ticket.nonce.data(), ticket.nonce.size(), nonce.data(), nonce.size(),
                       nullptr, &size, nullptr) != 0 ||
        size != ticket.nonce.size())
      return std::nullopt;
    ticket.issued = *issued;
    return ticket;
  } catch (const FileError&) {
    return std::nullopt;
  }
}

}  // namespace

std::string issue_ticket(Ticket ticket, const paseto::SigningKey& key) {
  for (const std::string& name : {ticket.scene, ticket.client, ticket.host})
    if (!is_name(name))
      throw std::invalid_argument("a name in a ticket must have 1 to 128 bytes of UTF-8");
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
  randombytes_buf(ticket.nonce.data(), ticket.nonce.size());
  using json_text::text;
  const std::string payload =
      json_text::object({{"scene", text(ticket.scene)},
                         {"client", text(ticket.client)},
                         {"role", text(name(ticket.role))},
                         {"host", text(ticket.host)},
                         {"term", json_text::number(ticket.epoch.term)},
                         {"holder", json_text::number(ticket.epoch.holder)},
                         {"iat", text(rfc3339(ticket.issued))},
                         {"exp", text(rfc3339(ticket.issued + kTicketLifetime))},
                         {"jti", text(hex(ticket.nonce))}});
  return paseto::sign(payload, key, footer_of(key.public_key()), kPurpose);
}

std::string_view name(TicketRefusal refusal) { return enum_name(kRefusalNames, refusal); }

void TicketKeys::set(const std::string& host, std::span<const paseto::PublicKey> keys) {
  forget(host);
  for (const paseto::PublicKey& key : keys.first(std::min(keys.size(), kMostTicketKeys))) {
    Key& known = keys_[footer_of(key)];
    known.key = key;
    known.hosts.insert(host);
  }
}

void TicketKeys::forget(const std::string& host) {
  for (auto& [footer, key] : keys_) key.hosts.erase(host);
  std::erase_if(keys_, [](const auto& entry) { return entry.second.hosts.empty(); });
}

const paseto::PublicKey* TicketKeys::find(std::string_view footer) const {
  const auto found = keys_.find(footer);
  return found != keys_.end() ? &found->second.key : nullptr;
}

void TicketGate::see_clock(std::chrono::sys_seconds now) {
  if (now > latest_) {
    // A day is longer than any period here. A wrong clock may say any year.
    elapsed_ += std::min<std::chrono::seconds>(now - latest_, std::chrono::days(1));
    latest_ = now;
  } else if (now < latest_ - kMostClockError) {
    used_until_ = newest_used_;
    latest_ = now;
  }
}

TicketGate::Checked TicketGate::check(std::string_view text, const TicketPlace& place,
                                      const TicketKeys& keys, std::chrono::sys_seconds now) {
  see_clock(now);
  const auto footer = paseto::unverified_footer(text);
  if (!footer) return {TicketRefusal::malformed, {}};
  const paseto::PublicKey* const key = keys.find(*footer);
  if (key == nullptr) return {TicketRefusal::unknown_key, {}};
  const auto payload = paseto::verify(text, *key, kPurpose);
  if (!payload) return {TicketRefusal::forged, {}};
  const auto ticket = read_payload(*payload);
  if (!ticket) return {TicketRefusal::malformed, {}};
  const auto refused = [&](TicketRefusal why) { return Checked{why, *ticket}; };
  if (ticket->scene != place.scene) return refused(TicketRefusal::wrong_scene);
  if (ticket->host != place.host) return refused(TicketRefusal::wrong_host);
  if (ticket->epoch != place.epoch) return refused(TicketRefusal::wrong_epoch);
  if (latest_ >= ticket->issued + kTicketLifetime + kMostClockError ||
      (used_until_ && ticket->issued <= *used_until_))
    return refused(TicketRefusal::expired);
  if (latest_ < ticket->issued - kMostClockError) return refused(TicketRefusal::early);
  switch (used_.use(ticket->nonce, elapsed_)) {
    case ReplayCache::Use::again:
      return refused(TicketRefusal::used);
    case ReplayCache::Use::full:
      return refused(TicketRefusal::too_many);
    case ReplayCache::Use::first:
      break;
  }
  newest_used_ = std::max(newest_used_, ticket->issued);
  return {std::nullopt, *ticket};
}

}  // namespace feltwire
