#pragma once
// A limited number of places, shared fairly between networks.

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "server/access/network.hpp"

namespace feltwire {

/// Places for connections. A new connection is never refused: if there is no place left, an old
/// connection loses its place. It is of the network that has the most places, and there the oldest
/// one of the member that has the most. A member or a network with as many as it may have loses its
/// own oldest. So who takes many places takes them from himself.
class ConnectionSlots {
 public:
  using Id = std::uint64_t;
  /// Tells those of one network apart: a host's address, or the name of a client.
  using Member = std::string;
  /// The host of an address, as a member of its network.
  static Member member_of(const asio::ip::address& address);

  static constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

  /// `most` places, of which one network has at most `most_of_network`, and members of one name at
  /// most `most_of_member` in all networks together. All at least 1.
  ConnectionSlots(std::size_t most, std::size_t most_of_network,
                  std::size_t most_of_member = kNoLimit)
      : most_(most), most_of_network_(most_of_network), most_of_member_(most_of_member) {}

  /// Gives a place to `id`, which has none. Returns the connection that lost its place for it, if
  /// there is one.
  std::optional<Id> take(Id id, const Network& network, const Member& member = {});
  /// Renews the time at which it took its place. It does nothing if it has none.
  void renew(Id id);
  /// Returns whether it had a place.
  bool leave(Id id);

  std::size_t size() const { return holders_.size(); }
  /// Returns how many places a network has.
  std::size_t size(const Network& network) const;

 private:
  using Turn = std::uint64_t;  // counts up: a lower value is an older place
  struct Place {
    Id id = 0;
    Member member;
  };
  using Line = std::map<Turn, Place>;
  struct Holder {
    Network network{};
    Turn turn = 0;
  };
  std::optional<Id> victim(const Network& newcomer, const Member& member) const;
  std::optional<Id> oldest_of_too_many(const Member& member) const;
  static Id oldest_of_most(const Line& line, const Member* newcomer);

  std::size_t most_, most_of_network_, most_of_member_;
  std::map<Network, Line> lines_;  // none of them empty
  std::map<Id, Holder> holders_;
  Turn next_ = 0;
};

}  // namespace feltwire
