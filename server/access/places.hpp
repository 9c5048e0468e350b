#pragma once
// A limited number of places, shared fairly between networks.

#include <cstdint>
#include <map>
#include <optional>

#include "server/access/network.hpp"

namespace feltwire {

/// Places for connections. A new connection is never refused: if there is no place left, an old
/// connection loses its place. It is the oldest one of the network that has the most places, so a
/// network that takes many places takes them from itself.
class Places {
 public:
  using Id = std::uint64_t;

  /// `most` places, of which one network has at most `most_of_network`. Both at least 1.
  Places(std::size_t most, std::size_t most_of_network)
      : most_(most), most_of_network_(most_of_network) {}

  /// Gives a place to `id`, which has none. Returns the connection that lost its place for it, if
  /// there is one.
  std::optional<Id> take(Id id, const Network& network);
  /// Renews the time at which it took its place. It does nothing if it has none.
  void renew(Id id);
  /// Returns whether it had a place.
  bool leave(Id id);

  std::size_t size() const { return holders_.size(); }
  /// Returns how many places a network has.
  std::size_t size(const Network& network) const;

 private:
  using Turn = std::uint64_t;  // counts up: a lower value is an older place
  using Line = std::map<Turn, Id>;
  struct Holder {
    Network network{};
    Turn turn = 0;
  };
  std::optional<Id> victim(const Network& newcomer) const;

  std::size_t most_, most_of_network_;
  std::map<Network, Line> lines_;  // none of them empty
  std::map<Id, Holder> holders_;
  Turn next_ = 0;
};

}  // namespace feltwire
