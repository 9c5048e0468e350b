#pragma once
// The turns in which connections may begin a TLS handshake. It has no socket and no clock.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/base/token_bucket.hpp"
#include "protocol/wire/datagram.hpp"
#include "server/access/network.hpp"

namespace feltwire {

struct TurnLimits {
  double rate = 50.0, burst = 100.0;  // [1/s] connections of one network, for ever; and at once
  Nanoseconds patience = std::chrono::seconds(3);  // a connection that waits longer has to go
  // Connections that may wait: of all, of one network, of one host.
  std::size_t waiting = 256, waiting_of_network = 64, waiting_of_host = 8;
};

/// Lets connections in at a limited rate for each network. Those above it wait. Of the waiting ones
/// of a network these come first:
///
///   1. of hosts that showed a good token lately (kRemembered);
///   2. of hosts that are not known to be wrong: none of their connections is in without having
///      shown a token, and none ended so lately (kBlamed);
///   3. of all other hosts that have not used up their share of the network's rate (kShare);
///   4. of the rest, so that a network with one busy host loses nothing.
///
/// Among equals comes first the host that was let in the longest time ago. So one host that
/// connects without end, or many that show no token, keep no neighbour out.
///
/// Its memory is bounded. Of more hosts or networks than it keeps, it forgets those that it heard
/// of the longest time ago, those that showed a good token last.
class ConnectionTurns {
 public:
  using Id = std::uint64_t;
  static constexpr double kShare = 0.25;  // of a host
  static constexpr std::chrono::minutes kRemembered{30};
  static constexpr std::chrono::seconds kBlamed{60};
  static constexpr std::size_t kMostNetworks = 1024, kMostHosts = 8192, kMostHostsOfNetwork = 256;

  explicit ConnectionTurns(const TurnLimits& limits) : limits_(limits) {}

  /// A connection has come, and waits from now on; no other has its `id`. Returns the one that has
  /// to go because there is no room to wait, perhaps this one. `now` never falls.
  std::optional<Id> arrive(Id id, const asio::ip::address& from, Nanoseconds now);
  /// Takes the next one that may come in now out of the waiting ones. Empty: none may.
  std::optional<Id> admit(Nanoseconds now);
  /// Takes one out that has waited for too long. Empty: there is none.
  std::optional<Id> give_up(Nanoseconds now);
  /// The fate of a connection that was let in: it showed a good token, it ended without one, or
  /// the other end had left while it waited.
  enum class Outcome { good, none, left };
  /// Call it exactly once for each connection that was let in. It allocates, and may throw, for
  /// `good` only.
  void judge(const asio::ip::address& from, Outcome outcome, Nanoseconds now);

  std::size_t waiting() const { return waiting_; }
  /// Hosts that it remembers.
  std::size_t hosts() const { return hosts_; }

 private:
  struct Waiting {
    Id id = 0;
    Nanoseconds since{0};
  };
  struct Host {
    explicit Host(const TokenBucket& whole) : share(whole) {}
    TokenBucket share;
    std::vector<Waiting> waiting;             // the oldest first
    std::size_t unjudged = 0;                 // connections that were let in
    std::optional<Nanoseconds> good, failed;  // the newest time of each
    bool sent_away = false;                   // since it was let in
    std::uint64_t let_in = 0, heard = 0;      // turns; 0: never
  };
  using Hosts = std::map<HostAddress, Host>;
  struct Net {
    explicit Net(const TokenBucket& whole) : budget(whole) {}
    TokenBucket budget;
    Hosts hosts;
    std::size_t waiting = 0;
    std::uint64_t heard = 0;  // turn
  };
  using Networks = std::map<Network, Net>;

  Net& network(const Network& key);
  Host& host(Net& net, const HostAddress& key);
  static int rank(const Host& host, Nanoseconds now);
  static bool goes_before(const Host& a, const Host& b, Nanoseconds now);
  std::optional<Id> make_room(Net& net, Host& newcomer, Nanoseconds now);
  Id take_out(Net& net, Host& host, std::size_t place);
  Host* next_of(Net& net, Nanoseconds now);
  Id send_away(Net& net, Host& host, std::size_t place);
  Id send_last_away(Net& net, Nanoseconds now);
  void forget_a_host(Hosts& hosts);
  bool forget_a_network();

  TurnLimits limits_;
  Networks networks_;
  std::size_t waiting_ = 0, hosts_ = 0;
  std::uint64_t turn_ = 0;
};

}  // namespace feltwire
