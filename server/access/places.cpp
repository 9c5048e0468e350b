#include "server/access/places.hpp"

namespace feltwire {

std::optional<Places::Id> Places::take(Id id, const Network& network) {
  const std::optional<Id> loser = victim(network);
  if (loser) leave(*loser);
  Line& line = lines_[network];
  line.emplace(next_, id);
  try {
    holders_.emplace(id, Holder{network, next_});
  } catch (...) {
    line.erase(next_);
    throw;
  }
  ++next_;
  return loser;
}

void Places::renew(Id id) {
  const auto found = holders_.find(id);
  if (found == holders_.end()) return;
  Line& line = lines_.at(found->second.network);
  line.erase(found->second.turn);
  found->second.turn = next_++;
  line.emplace(found->second.turn, id);
}

bool Places::leave(Id id) {
  const auto found = holders_.find(id);
  if (found == holders_.end()) return false;
  const auto line = lines_.find(found->second.network);
  line->second.erase(found->second.turn);
  if (line->second.empty()) lines_.erase(line);
  holders_.erase(found);
  return true;
}

std::size_t Places::size(const Network& network) const {
  const auto found = lines_.find(network);
  return found == lines_.end() ? 0 : found->second.size();
}

/// The connection that must make room for one more of this network; none while there is room.
std::optional<Places::Id> Places::victim(const Network& newcomer) const {
  const auto own = lines_.find(newcomer);
  if (own != lines_.end() && own->second.size() >= most_of_network_)
    return own->second.begin()->second;
  if (holders_.size() < most_) return std::nullopt;
  const Line* largest = nullptr;
  std::size_t most = 0;
  for (const auto& [network, line] : lines_) {
    // The newcomer counts, too: a network as large as the largest gives way to its own.
    const std::size_t count = line.size() + (network == newcomer ? 1 : 0);
    if (count < most || (count == most && line.begin()->first > largest->begin()->first)) continue;
    largest = &line;
    most = count;
  }
  return largest == nullptr ? std::nullopt : std::optional(largest->begin()->second);
}

}  // namespace feltwire
