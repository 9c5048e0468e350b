#include "server/join_rate.hpp"

#include <algorithm>

namespace feltwire {
namespace {

std::array<std::uint8_t, 8> network_of(const asio::ip::address& address) {
  std::array<std::uint8_t, 8> network{};
  if (address.is_v6() && !address.to_v6().is_v4_mapped()) {
    const auto bytes = address.to_v6().to_bytes();
    std::copy_n(bytes.begin(), network.size(), network.begin());
    return network;
  }
  const auto bytes =
      address.is_v4() ? address.to_v4().to_bytes()
                      : asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_bytes();
  // No network of IPv6 that is given out begins like this.
  network = {0xff, 0xff, 0xff, 0xff, bytes[0], bytes[1], bytes[2], bytes[3]};
  return network;
}

}  // namespace

bool JoinRate::allows(const asio::ip::address& address, Nanoseconds now) {
  return bucket(address, now).left >= 1.0;
}

void JoinRate::count(const asio::ip::address& address, Nanoseconds now) {
  bucket(address, now).left -= 1.0;
}

void JoinRate::fill(Bucket& bucket, Nanoseconds now) const {
  const double elapsed = std::chrono::duration<double>(now - bucket.at).count();
  bucket.left = std::min(burst_, bucket.left + rate_ * std::max(0.0, elapsed));
  bucket.at = now;
}

JoinRate::Bucket& JoinRate::bucket(const asio::ip::address& address, Nanoseconds now) {
  const Network network = network_of(address);
  auto found = buckets_.find(network);
  if (found == buckets_.end()) {
    if (buckets_.size() >= kMostAddresses)
      // A full bucket says no more than none.
      std::erase_if(buckets_, [&](const auto& entry) {
        Bucket filled = entry.second;
        fill(filled, now);
        return filled.left >= burst_;
      });
    if (buckets_.size() >= kMostAddresses) {
      fill(shared_, now);
      return shared_;
    }
    found = buckets_.emplace(network, Bucket{burst_, now}).first;
  }
  fill(found->second, now);
  return found->second;
}

}  // namespace feltwire
