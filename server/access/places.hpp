#pragma once
// A limited number of places, shared fairly between networks.

#include <cstdint>
#include <map>
#include <optional>

#include "server/access/network.hpp"

namespace feltwire {

/// Places for connections. Nobody is turned away: where there is no place left, somebody else loses
/// theirs. That is the one who took it longest ago, of the network that has the most, so that a
/// network that takes many places takes them from itself.
class Places {
 public:
  using Id = std::uint64_t;

  /// `most` places, of which one network has at most `most_of_network`. Both at least 1.
  Places(std::size_t most, std::size_t most_of_network)
      : most_(most), most_of_network_(most_of_network) {}

  /// Gives a place to `id`, which has none. The one who lost theirs for it, if anybody did.
  std::optional<Id> take(Id id, const Network& network);
  /// As if it had taken its place just now. Nothing happens if it has none.
  void renew(Id id);
  /// Whether it had one.
  bool leave(Id id);

  std::size_t size() const { return holders_.size(); }
  /// How many of them a network has.
  std::size_t size(const Network& network) const;

 private:
  using Turn = std::uint64_t;  // counts up: who has a lower one took the place earlier
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
