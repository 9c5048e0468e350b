#pragma once
// The sessions of all scenes, as the control thread knows them. It has no clock.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/token_bucket.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/control.hpp"
#include "server/access/tokens.hpp"
#include "server/scene/session_end.hpp"

namespace feltwire {

/// A session, from its request on.
struct ListedSession {
  std::string token, client;  // the token's id, and its holder's name
  std::string tool;           // as the client asked for it; empty: the first
  std::size_t scene = 0;      // its place among those of the server
  std::string scene_name;
  Role role = Role::observer;
  std::string who;                    // for the log
  Nanoseconds since{0};               // time of the server's clock
  SessionParameters parameters = {};  // in force
  TokenBucket fetches;                // requests for surfaces and solids
};

/// Owns the list of sessions, and the clients that may not join a scene for a while. It is on the
/// control thread.
class SessionDirectory {
 public:
  using Sessions = std::map<std::uint64_t, ListedSession>;
  const Sessions& sessions() const { return sessions_; }

  void enter(std::uint64_t id, ListedSession session);
  void erase(std::uint64_t id) { sessions_.erase(id); }
  /// Null: there is no such session.
  ListedSession* find(std::uint64_t id);
  /// The session if it is in a scene that the token opens; else null.
  ListedSession* find_open(const Token& token, std::uint64_t id);
  /// The session if it is the token's own, or the token is of an admin of its scene; else null.
  ListedSession* find_own(const Token& token, std::uint64_t id);

  std::size_t sessions_of(const std::string& client) const;
  std::size_t pointers() const;
  /// The sessions behind the number `after`, in scenes that the token opens.
  control::SessionList list(const Token& token, std::uint64_t after) const;

  /// Logs the sessions that have ended, and forgets them.
  void forget(const std::vector<EndedSession>& ended, Nanoseconds now);
  /// Whether a hand of the client broke the simulation of the scene lately
  /// (ServiceLimits::kDisturberPause).
  bool has_disturbed(const std::string& client, std::size_t scene, Nanoseconds now) const;

 private:
  Sessions sessions_;
  // Until when a client's hands may not enter a scene whose simulation they broke.
  std::map<std::pair<std::string, std::size_t>, Nanoseconds> disturbers_;
};

}  // namespace feltwire
