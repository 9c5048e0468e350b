#pragma once
// The fate of each datagram in one direction of a link. Pure: no socket, no clock.

#include <array>
#include <cstddef>
#include <cstdint>

#include "client/emulated_link/link_options.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// The UDP and IPv4 headers of each payload. They count for the bit rate.
inline constexpr std::size_t kHeadersOnTheWire = 28;  // [bytes]

struct LinkFate {
  enum class Loss : std::uint8_t { none, line, queue };
  Loss loss = Loss::none;                 // on the line, or in the full queue before it
  int copies = 0;                         // that arrive: 0, 1 or 2
  std::array<Nanoseconds, 2> arrivals{};  // of these, not necessarily in order
};

/// The fate of datagram n is a function of the key, n and the options alone, with three exceptions:
/// the queue, a trace and keep_order depend on when and how large the other datagrams were. The
/// steps, in their order on the way:
///   1. The queue and the line of a bit rate. A datagram that finds more than `queue` bytes waiting
///      or being sent is dropped (tail drop). Else it leaves (size + headers) / rate after those.
///   2. Loss: a Gilbert chain (Gilbert 1960; Elliott's with loss 1 in the bad state and 0 in the
///      good one). It begins in its stationary state and moves on with each datagram, also with
///      those that the queue dropped.
///   3. The delay: mean + jitter X, X of zero mean and unit variance, not below 0.
///   4. A share of the datagrams is held back by reorder_delay. A share arrives twice; the copy has
///   a
///      delay of its own and takes no bit rate.
class LinkModel {
 public:
  /// `key`: the seed of the random numbers (link_key()). Precondition: validate(options) passes.
  LinkModel(LinkOptions options, std::uint64_t key);

  /// The fate of the next datagram, of `size` bytes of payload, that enters `now`. Times must not
  /// fall from call to call.
  LinkFate next(std::size_t size, Nanoseconds now) noexcept;

  /// Why delay, jitter and loss cannot be set to these; empty if they can. It reads only members
  /// that set() does not change.
  std::optional<std::string> refuses(const LinkQuality& link) const;
  /// For the next datagrams. Precondition: refuses() refuses nothing.
  void set(const LinkQuality& link) noexcept;

  const LinkOptions& options() const { return options_; }

 private:
  double uniform(std::uint64_t draw) const noexcept;
  void set_chain() noexcept;
  bool next_is_lost() noexcept;
  bool leaves_queue(std::size_t size, Nanoseconds now, Nanoseconds& leaves) noexcept;
  Nanoseconds delay(std::uint64_t draw) const noexcept;
  Nanoseconds in_order(Nanoseconds arrival) noexcept;

  LinkOptions options_;
  std::uint64_t key_;
  double fall_ill_, recover_;  // probability of good to bad and back, for each datagram
  std::uint64_t ordinal_ = 0;
  bool bad_ = false;
  Nanoseconds start_{0};           // of the first datagram, when a trace begins
  Nanoseconds line_free_{0};       // time at which the last byte of the last datagram has left
  Nanoseconds newest_arrival_{0};  // with keep_order no later datagram arrives before this
};

enum class LinkDirection : std::uint8_t { up, down };

/// The key of one direction of one client's link: clients are counted from 0, and each has its own
/// random numbers.
std::uint64_t link_key(std::uint64_t seed, std::uint64_t client, LinkDirection direction) noexcept;

}  // namespace feltwire
