#include "server/access/connection_slots.hpp"

#include <string_view>
#include <utility>

namespace feltwire {

ConnectionSlots::Member ConnectionSlots::member_of(const asio::ip::address& address) {
  const HostAddress host = host_of(address);
  return {host.begin(), host.end()};
}

std::optional<ConnectionSlots::Id> ConnectionSlots::take(Id id, const Network& network,
                                                         const Member& member) {
  const std::optional<Id> loser = victim(network, member);
  if (loser) leave(*loser);
  Line& line = lines_[network];
  line.emplace(next_, Place{id, member});
  try {
    holders_.emplace(id, Holder{network, next_});
  } catch (...) {
    line.erase(next_);
    throw;
  }
  ++next_;
  return loser;
}

void ConnectionSlots::renew(Id id) {
  const auto found = holders_.find(id);
  if (found == holders_.end()) return;
  Line& line = lines_.at(found->second.network);
  auto place = line.extract(found->second.turn);
  place.key() = found->second.turn = next_++;
  line.insert(std::move(place));
}

bool ConnectionSlots::leave(Id id) {
  const auto found = holders_.find(id);
  if (found == holders_.end()) return false;
  const auto line = lines_.find(found->second.network);
  line->second.erase(found->second.turn);
  if (line->second.empty()) lines_.erase(line);
  holders_.erase(found);
  return true;
}

std::size_t ConnectionSlots::size(const Network& network) const {
  const auto found = lines_.find(network);
  return found == lines_.end() ? 0 : found->second.size();
}

/// Returns the oldest connection of the member (a host or a client name) that has the most
/// connections in `line`. If two members have equally many, returns the older connection.
/// `newcomer`: member of the new connection, which counts too; null: the new connection is of
/// another network. Precondition: `line` is not empty.
ConnectionSlots::Id ConnectionSlots::oldest_of_most(const Line& line, const Member* newcomer) {
  std::map<std::string_view, std::size_t> counts;
  if (newcomer != nullptr) ++counts[*newcomer];
  for (const auto& [turn, place] : line) ++counts[place.member];
  const Place* oldest = nullptr;
  std::size_t most = 0;
  for (const auto& [turn, place] : line) {
    const std::size_t count = counts[place.member];
    if (count <= most) continue;
    most = count;
    oldest = &place;
  }
  return oldest->id;
}

/// Returns the oldest connection of a member that already has most_of_member_ connections. Empty if
/// the member has fewer.
std::optional<ConnectionSlots::Id> ConnectionSlots::oldest_of_too_many(const Member& member) const {
  std::size_t count = 0;
  std::optional<std::pair<Turn, Id>> oldest;
  for (const auto& [network, line] : lines_)
    for (const auto& [turn, place] : line) {
      if (place.member != member) continue;
      ++count;
      if (!oldest || turn < oldest->first) oldest.emplace(turn, place.id);
    }
  if (count < most_of_member_) return std::nullopt;
  return oldest->second;
}

/// Returns the connection that must end to make room for a new one of this member and network.
/// Empty if there is room.
std::optional<ConnectionSlots::Id> ConnectionSlots::victim(const Network& newcomer,
                                                           const Member& member) const {
  if (const auto own = oldest_of_too_many(member)) return own;
  const auto own = lines_.find(newcomer);
  if (own != lines_.end() && own->second.size() >= most_of_network_)
    return oldest_of_most(own->second, &member);
  if (holders_.size() < most_) return std::nullopt;
  const Line* largest = nullptr;
  std::size_t most = 0;
  for (const auto& [network, line] : lines_) {
    // Count the new connection too. So if its network is one of the largest, that network makes
    // room.
    const std::size_t count = line.size() + (network == newcomer ? 1 : 0);
    if (count < most || (count == most && line.begin()->first > largest->begin()->first)) continue;
    largest = &line;
    most = count;
  }
  if (largest == nullptr) return std::nullopt;
  const bool its_own = own != lines_.end() && largest == &own->second;
  return oldest_of_most(*largest, its_own ? &member : nullptr);
}

}  // namespace feltwire
