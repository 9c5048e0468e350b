#pragma once
// An emulated link for datagrams: they enter, and they leave at their due time. Time is an
// argument.

#include <cstdint>
#include <optional>

#include "client/emulated_link/delay_queue.hpp"
#include "client/emulated_link/link_model.hpp"

namespace feltwire {

/// Counts of the datagrams of one direction: entered + duplicated = delivered + lost +
/// queue_dropped + overflowed + in_flight.
struct LinkStatistics {
  std::uint64_t entered = 0;
  std::uint64_t delivered = 0;      // with copies
  std::uint64_t lost = 0;           // on the line
  std::uint64_t queue_dropped = 0;  // before the line of a bit rate
  std::uint64_t overflowed = 0;     // dropped because the emulator had no memory for more
  std::uint64_t duplicated = 0;     // copies made
  std::uint64_t reordered = 0;      // came after one that entered later (RFC 4737)
  std::uint64_t in_flight = 0;
  Nanoseconds least_delay{0}, greatest_delay{0}, total_delay{0};  // of those delivered
};

class OneWayLink {
 public:
  OneWayLink(const LinkOptions& options, std::uint64_t key, std::size_t capacity)
      : model_(options, key), queue_(capacity) {}

  /// Takes a datagram; the model may lose it. Times must not fall from call to call.
  void enter(Bytes datagram, Nanoseconds now) noexcept;

  /// The time at which the next datagram leaves; empty if there is none.
  std::optional<Nanoseconds> next_due() const noexcept { return queue_.next_due(); }

  /// The next datagram that is due by now; its bytes are valid until the next enter().
  std::optional<Bytes> leave(Nanoseconds now) noexcept;

  /// Why delay, jitter and loss cannot be set to these; empty if they can. The answer is the same
  /// at any time, and any thread may ask.
  std::optional<std::string> refuses(const LinkQuality& link) const { return model_.refuses(link); }
  /// For datagrams that enter from now on. Precondition: refuses() refuses nothing.
  void set(const LinkQuality& link) noexcept { model_.set(link); }

  LinkStatistics statistics() const noexcept;
  const LinkOptions& options() const { return model_.options(); }

 private:
  LinkModel model_;
  DelayQueue queue_;
  LinkStatistics statistics_;
  std::uint64_t latest_ordinal_ = 0;  // of those delivered; 0: none
};

struct TwoWayLink {
  std::string text;  // of the options, as the user gave it
  std::uint64_t seed;
  OneWayLink up, down;

  /// The link of the client with this number, counted from 0. `capacity`: the largest number of
  /// datagrams on their way in each direction.
  TwoWayLink(const TwoWayLinkOptions& options, std::uint64_t client, std::size_t capacity)
      : text(options.text),
        seed(options.seed),
        up(options.up, link_key(options.seed, client, LinkDirection::up), capacity),
        down(options.down, link_key(options.seed, client, LinkDirection::down), capacity) {}

  std::optional<Nanoseconds> next_due() const noexcept {
    const auto a = up.next_due(), b = down.next_due();
    return a && b ? std::min(*a, *b) : a ? a : b;
  }
};

}  // namespace feltwire
