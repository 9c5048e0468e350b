#pragma once
// Limits how often wrong tokens are answered.

#include <algorithm>

#include "server/access/network.hpp"
#include "server/access/rate_limit.hpp"

namespace feltwire {

/// Counts by host first: each has a share of its network's, so that nobody's guesses use up what a
/// neighbour may get wrong. A good token is never counted.
class WrongTokens {
 public:
  static constexpr double kShare = 0.5;  // of a host

  /// `rate` [1/s] sustained, `burst` at once, of one network.
  WrongTokens(double rate, double burst)
      : hosts_(kShare * rate, std::max(1.0, kShare * burst)), networks_(rate, burst) {}

  /// Returns whether one more from this address is answered as such, and counts it then.
  bool take(const asio::ip::address& from, Nanoseconds now) {
    return hosts_.take(host_of(from), now) && networks_.take(network_of(from), now);
  }

 private:
  RateLimit<HostAddress> hosts_;
  RateLimit<Network> networks_;
};

}  // namespace feltwire
