#pragma once
// How many requests a client may make, and the refusals of those beyond.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "protocol/wire/control.hpp"
#include "server/access/rate_limit.hpp"
#include "server/access/tokens.hpp"

namespace feltwire {

struct ServiceLimits {
  std::size_t sessions_per_client = 16;
  std::size_t pointers = 4;  // sessions of role pointer, of all clients together
  /// [1/s] sustained, and at once: joins, changes of parameters and reloads, an observer's
  /// descriptions and lists of scenes, each for all tokens with one client's name; wrong tokens,
  /// for one network.
  double join_rate = 20.0, join_burst = 60.0;
  /// [1/s] sustained, and at once: all requests of one client's name that have no other limit.
  double request_rate = 200.0, request_burst = 1000.0;
  /// [1/s] sustained, and at once: parts and lists of what a session's client fetches in full. The
  /// most that an honest one asks for at once is some 750 (docs/limits.md).
  double fetch_rate = 100.0, fetch_burst = 2000.0;
  /// A client whose hand broke the simulation of a scene again and again (SessionEnd::disturbing)
  /// can join that scene with no hand for this time.
  static constexpr std::chrono::seconds kDisturberPause{60};
};

struct ServiceCounters {
  std::uint64_t unauthenticated = 0;  // requests without a valid token
  std::uint64_t forbidden = 0;        // beyond the token's role or scene
  std::uint64_t too_many = 0;         // above a limit
};

/// "an observer"
std::string holder(Role role);

/// Owns the rates of requests by the client's name, and the counters of refusals. It is on the
/// control thread. Each function returns the refusal; empty: the request may go on.
class RequestLimits {
 public:
  explicit RequestLimits(const ServiceLimits& limits);

  /// The token has a role that covers `role`.
  std::optional<control::Refused> check_role(Role role, const Token& token);
  std::optional<control::Refused> check_joins(const std::string& client);
  /// For requests that cost work of a scene's thread or of the machine.
  std::optional<control::Refused> check_changes(const std::string& client);
  /// For an observer's questions: they cost work of a scene's thread or of this one.
  std::optional<control::Refused> check_questions(const Token& token);
  /// For all requests, so that no client keeps this thread busy.
  std::optional<control::Refused> check_requests(const std::string& client);

  /// Makes a refusal for another reason, and counts it.
  control::Refused refuse(control::RefusalCode code, std::string reason);
  const ServiceCounters& counters() const { return counters_; }

 private:
  RateLimit<std::string> joins_, changes_, questions_, requests_;
  ServiceCounters counters_;
};

}  // namespace feltwire
