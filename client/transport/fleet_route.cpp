#include "client/transport/fleet_route.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace feltwire {

FleetRoute::FleetRoute(ServerAccess first)
    : first_(std::move(first)), host_(first_), hosts_{first_} {}

void FleetRoute::take(const Joined& joined) {
  admit(highest_, joined.accepted.epoch);
  std::vector<ServerAccess> hosts{joined.host};
  const auto add = [&](const ServerAccess& host) {
    const bool known = std::ranges::any_of(
        hosts, [&](const ServerAccess& other) { return other.endpoint == host.endpoint; });
    if (!known) hosts.push_back(host);
  };
  for (const ServerAccess& other : joined.others) add(other);
  add(first_);
  hosts_ = std::move(hosts);
  host_ = joined.host;
}

Joined FleetRoute::join(const control::JoinRequest& request, std::chrono::milliseconds timeout,
                        const GrantLimits& limits) {
  std::exception_ptr refused, failed;
  silent_.clear();
  for (const ServerAccess& host : std::vector<ServerAccess>(hosts_)) try {
      Joined joined = follow(host, request, timeout, limits);
      take(joined);
      return joined;
    } catch (const LastingError&) {
      if (!refused) refused = std::current_exception();
    } catch (const SessionError&) {
      if (!failed) failed = std::current_exception();
    }
  // The next join begins with the hosts that have answered.
  std::stable_partition(hosts_.begin(), hosts_.end(), [this](const ServerAccess& host) {
    return std::ranges::count(silent_, host.endpoint) == 0;
  });
  std::rethrow_exception(failed ? failed : refused);
}

/// Asks one host, and follows its redirects.
Joined FleetRoute::follow(const ServerAccess& from, control::JoinRequest request,
                          std::chrono::milliseconds timeout, const GrantLimits& limits) {
  ServerAccess server = from;
  for (int redirects = 0;; ++redirects) {
    if (std::ranges::count(silent_, server.endpoint) > 0)
      throw SessionError(to_string(server.endpoint) +
                         " serves the scene and gives no answer; another host may take it over");
    request.epoch = highest_;
    request.follows_redirects = true;
    std::variant<Joined, Redirection> answer = [&] {
      try {
        return ask_to_join(server, request, timeout, limits);
      } catch (const NoAnswer&) {
        silent_.push_back(server.endpoint);
        throw;
      }
    }();
    if (auto* joined = std::get_if<Joined>(&answer)) return std::move(*joined);
    auto& next = std::get<Redirection>(answer);
    admit(highest_, next.epoch);
    if (redirects == kMostRedirects)
      throw SessionError(to_string(from.endpoint) + " sends this client on and on, at last to " +
                         to_string(next.host.endpoint) + "; its fleet does not agree yet");
    server = std::move(next.host);
    request.ticket = std::move(next.ticket);
  }
}

}  // namespace feltwire
