#pragma once
// Tickets: a host that redirects a client vouches for it to the host that it sends it to. The
// client carries the text and cannot read more out of it than it knows.
//
// A ticket is a PASETO v4.public token with a JSON payload and the key's name in the footer. It is
// good for one join, of one client, in one scene, at one epoch and so at one host process, for 30
// seconds. Any host can check it without asking another.

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "protocol/crypto/paseto.hpp"
#include "protocol/fleet/epoch.hpp"
#include "protocol/session/role.hpp"
#include "server/fleet/replay_cache.hpp"
#include "server/fleet/scene_record.hpp"

namespace feltwire {

inline constexpr std::chrono::seconds kTicketLifetime{30};
inline constexpr std::chrono::seconds kMostClockError{5};  // of two hosts' clocks

struct Ticket {
  std::string scene, client;  // names of 1 to 128 bytes
  Role role = Role::observer;
  std::string host;  // that it is for
  Epoch epoch;       // whose holder is the process of that host
  std::chrono::sys_seconds issued;
  ReplayCache::Nonce nonce{};

  friend bool operator==(const Ticket&, const Ticket&) = default;
};

/// Signs the ticket with a new nonce (end_without_random_numbers()), whatever nonce it has. Throws
/// std::invalid_argument for a name that is empty, too long or not UTF-8: no host would read it.
std::string issue_ticket(Ticket ticket, const paseto::SigningKey& key);

/// Why a ticket opens nothing, in the order of the checks.
enum class TicketRefusal {
  malformed,    // it is no ticket
  unknown_key,  // no host of the fleet has announced its key
  forged,       // the key that it names has not signed it
  wrong_scene,
  wrong_host,
  wrong_epoch,  // of a former owner, or of one that is not the owner yet
  expired,
  early,  // issued in the future: the clock of one of the hosts is wrong
  used,
  too_many,  // there is no room to remember that it was used
};
std::string_view name(TicketRefusal refusal);

/// The keys of all hosts of a fleet whose tickets are accepted.
class TicketKeys {
 public:
  /// Takes the place of the host's former keys. Keys beyond kMostTicketKeys are left out. A key
  /// that several hosts announce is accepted until the last of them is forgotten.
  void set(const std::string& host, std::span<const paseto::PublicKey> keys);
  void forget(const std::string& host);
  /// The key with this footer of tickets; null: there is none.
  const paseto::PublicKey* find(std::string_view footer) const;
  std::size_t size() const noexcept { return keys_.size(); }

 private:
  struct Key {
    std::set<std::string> hosts;  // that have announced it
    paseto::PublicKey key{};
  };
  std::map<std::string, Key, std::less<>> keys_;  // by footer
};

/// The place where a ticket is shown.
struct TicketPlace {
  std::string_view scene, host;
  Epoch epoch;  // at which this host serves the scene
};

/// Checks tickets of one host process.
class TicketGate {
 public:
  /// At most `capacity` tickets are accepted in a minute or so; see ReplayCache for the memory.
  explicit TicketGate(std::size_t capacity)
      : used_(kTicketLifetime + 2 * kMostClockError, capacity) {}

  struct Checked {
    std::optional<TicketRefusal> refusal;  // empty: the ticket opens the scene, this once
    Ticket ticket;                         // unless it is malformed, forged or of an unknown key
  };
  /// `now` may run back. By kMostClockError at most, it counts as standing still. A clock that is
  /// set back by more makes no used ticket valid: tickets that are not newer than the newest used
  /// one count as expired. New ones are accepted at once.
  Checked check(std::string_view text, const TicketPlace& place, const TicketKeys& keys,
                std::chrono::sys_seconds now);

 private:
  void see_clock(std::chrono::sys_seconds now);

  std::chrono::sys_seconds latest_{};       // since the clock was set back
  std::chrono::sys_seconds newest_used_{};  // issue of a ticket
  std::optional<std::chrono::sys_seconds>
      used_until_;          // at the last time that the clock was set back
  Nanoseconds elapsed_{0};  // never runs back
  ReplayCache used_;
};

}  // namespace feltwire
