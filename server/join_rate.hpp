#pragma once
// How often one address may try to get in.

#include <array>
#include <asio/ip/address.hpp>
#include <cstdint>
#include <map>

#include "protocol/datagram.hpp"

namespace feltwire {

/// A token bucket for each address (IPv6: for each network of 64 bits, as a host has a whole one).
/// Remembers at most kMostAddresses; beyond them strangers share one bucket.
class JoinRate {
 public:
  static constexpr std::size_t kMostAddresses = 4096;

  /// `rate` [1/s] for ever, `burst` at once.
  JoinRate(double rate, double burst) : rate_(rate), burst_(burst), shared_{burst, {}} {}

  /// Whether one more is allowed. `now` never falls.
  bool allows(const asio::ip::address& address, Nanoseconds now);
  /// One more was made.
  void count(const asio::ip::address& address, Nanoseconds now);

 private:
  struct Bucket {
    double left;
    Nanoseconds at;
  };
  using Network = std::array<std::uint8_t, 8>;
  Bucket& bucket(const asio::ip::address& address, Nanoseconds now);
  void fill(Bucket& bucket, Nanoseconds now) const;

  double rate_, burst_;
  std::map<Network, Bucket> buckets_;
  Bucket shared_;
};

}  // namespace feltwire
