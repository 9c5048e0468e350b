#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/emulated_link/link_model.hpp"

namespace feltwire::teleop {

/// A direction of a network in virtual time.
template <class Message>
class OneWayLink {
 public:
  OneWayLink(const LinkOptions& options, std::uint64_t key) : model_(options, key) {}

  /// `now` [s]; cut: the datagram does not arrive.
  void send(const Message& message, double now, bool cut = false) {
    constexpr std::size_t kSize = 100;  // [bytes] of a datagram; no bit rate is limited here
    const Nanoseconds entered(std::llround(now * 1e9));
    const LinkFate fate = model_.next(kSize, entered);
    if (cut) return;
    for (int i = 0; i < fate.copies; ++i)
      waiting_.push_back(
          {fate.arrivals[static_cast<std::size_t>(i)], std::make_unique<Message>(message)});
  }

  /// The datagrams that have arrived since the last call, in the order of arrival.
  std::span<const Message> receive(double now) {
    const Nanoseconds time(std::llround(now * 1e9));
    const auto first = std::stable_partition(waiting_.begin(), waiting_.end(),
                                             [&](const Waiting& w) { return w.due > time; });
    std::stable_sort(first, waiting_.end(),
                     [](const Waiting& a, const Waiting& b) { return a.due < b.due; });
    arrived_.clear();
    std::for_each(first, waiting_.end(), [&](const Waiting& w) { arrived_.push_back(*w.message); });
    waiting_.erase(first, waiting_.end());
    return arrived_;
  }

 private:
  struct Waiting {
    Nanoseconds due;
    std::unique_ptr<Message> message;  // a large one is not moved while it waits
  };
  LinkModel model_;
  std::vector<Waiting> waiting_;
  std::vector<Message> arrived_;
};

}  // namespace feltwire::teleop
