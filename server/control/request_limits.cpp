#include "server/control/request_limits.hpp"

#include <utility>

#include "protocol/net/clock.hpp"

namespace feltwire {

using control::RefusalCode;
using control::Refused;

std::string holder(Role role) {
  return (role == Role::pointer || role == Role::follower ? "a " : "an ") + std::string(name(role));
}

RequestLimits::RequestLimits(const ServiceLimits& limits)
    : joins_(limits.join_rate, limits.join_burst),
      changes_(limits.join_rate, limits.join_burst),
      questions_(limits.join_rate, limits.join_burst),
      requests_(limits.request_rate, limits.request_burst) {}

std::optional<Refused> RequestLimits::check_role(Role role, const Token& token) {
  if (covers(token.role, role)) return std::nullopt;
  return refuse(RefusalCode::forbidden, "this is for " + std::string(name(role)) +
                                            "s; the token is for " + holder(token.role));
}

std::optional<Refused> RequestLimits::check_joins(const std::string& client) {
  if (joins_.take(client, monotonic_now())) return std::nullopt;
  return refuse(RefusalCode::too_many, "client '" + client + "' joins too often; wait a moment");
}

std::optional<Refused> RequestLimits::check_changes(const std::string& client) {
  if (changes_.take(client, monotonic_now())) return std::nullopt;
  return refuse(RefusalCode::too_many, "client '" + client +
                                           "' changes parameters or reloads too often; wait a "
                                           "moment");
}

std::optional<Refused> RequestLimits::check_questions(const Token& token) {
  if (covers(token.role, Role::admin) || questions_.take(token.client, monotonic_now()))
    return std::nullopt;
  return refuse(RefusalCode::too_many,
                "client '" + token.client +
                    "' asks for descriptions and lists too often; ask twice a second at most");
}

std::optional<Refused> RequestLimits::check_requests(const std::string& client) {
  if (requests_.take(client, monotonic_now())) return std::nullopt;
  return refuse(RefusalCode::too_many,
                "client '" + client + "' asks too often; wait a moment between requests");
}

Refused RequestLimits::refuse(RefusalCode code, std::string reason) {
  if (code == RefusalCode::unauthenticated) ++counters_.unauthenticated;
  if (code == RefusalCode::forbidden) ++counters_.forbidden;
  if (code == RefusalCode::too_many) ++counters_.too_many;
  return {code, std::move(reason)};
}

}  // namespace feltwire
