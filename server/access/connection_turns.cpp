#include "server/access/connection_turns.hpp"

#include <algorithm>
#include <tuple>

namespace feltwire {

ConnectionTurns::Net& ConnectionTurns::network(const Network& key) {
  auto found = networks_.find(key);
  if (found == networks_.end()) {
    while (networks_.size() >= kMostNetworks && forget_a_network()) {
    }
    found = networks_.try_emplace(key, TokenBucket(limits_.rate, limits_.burst)).first;
  }
  found->second.heard = ++turn_;
  return found->second;
}

ConnectionTurns::Host& ConnectionTurns::host(Net& net, const HostAddress& key) {
  auto found = net.hosts.find(key);
  if (found == net.hosts.end()) {
    if (net.hosts.size() >= kMostHostsOfNetwork) forget_a_host(net.hosts);
    if (hosts_ >= kMostHosts) {
      const auto largest = std::ranges::max_element(
          networks_, {}, [](const auto& entry) { return entry.second.hosts.size(); });
      forget_a_host(largest->second.hosts);
    }
    const TokenBucket share(kShare * limits_.rate, std::max(1.0, kShare * limits_.burst));
    found = net.hosts.try_emplace(key, share).first;
    ++hosts_;
  }
  found->second.heard = ++turn_;
  return found->second;
}

/// Forgets a host without waiting connections, if there is one: a host that showed no valid token
/// if possible, then one that was not sent away, then the one that connected the longest time ago.
void ConnectionTurns::forget_a_host(Hosts& hosts) {
  auto oldest = hosts.end();
  const auto order = [](const Host& h) {
    return std::tuple(h.good.has_value(), h.sent_away, h.heard);
  };
  for (auto at = hosts.begin(); at != hosts.end(); ++at)
    if (at->second.waiting.empty() &&
        (oldest == hosts.end() || order(at->second) < order(oldest->second)))
      oldest = at;
  if (oldest == hosts.end()) return;
  hosts.erase(oldest);
  --hosts_;
}

/// Forgets a network without waiting connections: one where no host showed a valid token if
/// possible, then the one that connected the longest time ago. Returns false if there is none.
bool ConnectionTurns::forget_a_network() {
  auto oldest = networks_.end();
  const auto order = [](const Net& net) {
    return std::tuple(
        std::ranges::any_of(net.hosts,
                            [](const auto& entry) { return entry.second.good.has_value(); }),
        net.heard);
  };
  for (auto at = networks_.begin(); at != networks_.end(); ++at)
    if (at->second.waiting == 0 &&
        (oldest == networks_.end() || order(at->second) < order(oldest->second)))
      oldest = at;
  if (oldest == networks_.end()) return false;
  hosts_ -= oldest->second.hosts.size();
  networks_.erase(oldest);
  return true;
}

int ConnectionTurns::rank(const Host& host, Nanoseconds now) {
  const bool has_share = host.share.has_one(now);
  if (has_share && host.good && now - *host.good < kRemembered) return 1;
  const bool failed = host.failed && now - *host.failed < kBlamed;
  if (has_share && !failed && host.unjudged == 0) return 2;
  return has_share ? 3 : 4;
}

bool ConnectionTurns::goes_before(const Host& a, const Host& b, Nanoseconds now) {
  return std::tuple(rank(a, now), !a.sent_away, a.let_in, a.waiting.front().id) <
         std::tuple(rank(b, now), !b.sent_away, b.let_in, b.waiting.front().id);
}

/// Returns the host of `net` whose connection is admitted next. Null if no connection waits.
ConnectionTurns::Host* ConnectionTurns::next_of(Net& net, Nanoseconds now) {
  Host* next = nullptr;
  for (auto& [key, host] : net.hosts)
    if (!host.waiting.empty() && (next == nullptr || goes_before(host, *next, now))) next = &host;
  return next;
}

ConnectionTurns::Id ConnectionTurns::take_out(Net& net, Host& host, std::size_t place) {
  const auto at = host.waiting.begin() + static_cast<std::ptrdiff_t>(place);
  const Id id = at->id;
  host.waiting.erase(at);
  --net.waiting;
  --waiting_;
  return id;
}

ConnectionTurns::Id ConnectionTurns::send_away(Net& net, Host& host, std::size_t place) {
  host.sent_away = true;
  return take_out(net, host, place);
}

/// Takes out the newest connection of the host whose turn is last, and returns it. Precondition: a
/// connection of `net` waits.
ConnectionTurns::Id ConnectionTurns::send_last_away(Net& net, Nanoseconds now) {
  Host* last = nullptr;
  for (auto& [key, host] : net.hosts)
    if (!host.waiting.empty() && (last == nullptr || !goes_before(host, *last, now))) last = &host;
  return send_away(net, *last, last->waiting.size() - 1);
}

/// If too many connections wait, takes out the one that must leave and returns it.
std::optional<ConnectionTurns::Id> ConnectionTurns::make_room(Net& net, Host& newcomer,
                                                              Nanoseconds now) {
  if (newcomer.waiting.size() > limits_.waiting_of_host) return send_away(net, newcomer, 0);
  if (net.waiting > limits_.waiting_of_network) return send_last_away(net, now);
  if (waiting_ <= limits_.waiting) return std::nullopt;
  auto& largest = *std::ranges::max_element(networks_, {},
                                            [](const auto& entry) { return entry.second.waiting; });
  return send_last_away(largest.second, now);
}

std::optional<ConnectionTurns::Id> ConnectionTurns::arrive(Id id, const asio::ip::address& from,
                                                           Nanoseconds now) {
  Net& net = network(network_of(from));
  Host& own = host(net, host_of(from));
  own.waiting.push_back({id, now});
  ++net.waiting;
  ++waiting_;
  return make_room(net, own, now);
}

std::optional<ConnectionTurns::Id> ConnectionTurns::admit(Nanoseconds now) {
  if (waiting_ == 0) return std::nullopt;
  for (auto& [key, net] : networks_) {
    if (net.waiting == 0 || !net.budget.take(now)) continue;
    Host& next = *next_of(net, now);
    next.share.take(now);
    next.let_in = ++turn_;
    next.sent_away = false;
    ++next.unjudged;
    return take_out(net, next, 0);
  }
  return std::nullopt;
}

std::optional<ConnectionTurns::Id> ConnectionTurns::give_up(Nanoseconds now) {
  if (waiting_ == 0) return std::nullopt;
  for (auto& [key, net] : networks_) {
    if (net.waiting == 0) continue;
    for (auto& [address, host] : net.hosts)
      if (!host.waiting.empty() && now - host.waiting.front().since >= limits_.patience)
        return send_away(net, host, 0);
  }
  return std::nullopt;
}

void ConnectionTurns::judge(const asio::ip::address& from, Outcome outcome, Nanoseconds now) {
  const Network key = network_of(from);
  if (outcome == Outcome::good) host(network(key), host_of(from));
  const auto found = networks_.find(key);
  if (found == networks_.end()) return;
  Net& net = found->second;
  const auto known = net.hosts.find(host_of(from));
  if (known == net.hosts.end()) return;
  Host& own = known->second;
  if (own.unjudged > 0) --own.unjudged;
  switch (outcome) {
    case Outcome::good:
      own.good = now;
      break;
    case Outcome::none:
      own.failed = now;
      break;
    case Outcome::left:  // no handshake was made: give back its part of the rate limits
      net.budget.charge(-1.0);
      own.share.charge(-1.0);
      break;
  }
}

}  // namespace feltwire
