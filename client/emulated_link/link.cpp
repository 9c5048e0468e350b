#include "client/emulated_link/link.hpp"

#include <algorithm>

namespace feltwire {

void OneWayLink::enter(Bytes datagram, Nanoseconds now) noexcept {
  const std::uint64_t ordinal = ++statistics_.entered;
  const LinkFate fate = model_.next(datagram.size(), now);
  if (fate.loss == LinkFate::Loss::line) ++statistics_.lost;
  if (fate.loss == LinkFate::Loss::queue) ++statistics_.queue_dropped;
  if (fate.copies == 2) ++statistics_.duplicated;
  for (int i = 0; i < fate.copies; ++i)
    if (!queue_.push(datagram, fate.arrivals[static_cast<std::size_t>(i)], now, ordinal))
      ++statistics_.overflowed;
}

std::optional<Bytes> OneWayLink::leave(Nanoseconds now) noexcept {
  const auto due = queue_.next_due();
  if (!due || *due > now) return std::nullopt;
  const DelayQueue::Entry entry = queue_.pop();
  LinkStatistics& s = statistics_;
  const Nanoseconds took = now - entry.entered;
  s.least_delay = s.delivered == 0 ? took : std::min(s.least_delay, took);
  s.greatest_delay = std::max(s.greatest_delay, took);
  s.total_delay += took;
  ++s.delivered;
  if (entry.ordinal < latest_ordinal_) ++s.reordered;
  latest_ordinal_ = std::max(latest_ordinal_, entry.ordinal);
  return queue_.bytes(entry);
}

LinkStatistics OneWayLink::statistics() const noexcept {
  LinkStatistics s = statistics_;
  s.in_flight = queue_.size();
  return s;
}

}  // namespace feltwire
