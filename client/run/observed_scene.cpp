#include "client/run/observed_scene.hpp"

#include <span>

namespace feltwire {
namespace {

std::uint32_t key(const SeenHand& hand) { return hand.number; }
std::uint16_t key(const SeenBody& body) { return body.object; }

/// Removes the entries of `known` in the range [from, end) that `seen` lacks, and updates the
/// others. Both lists are sorted. `gone`: removed keys. Returns the number of new entries that
/// exceed the limit `most`.
template <class Key, class Seen>
std::uint64_t renew(std::map<Key, Seen>& known, std::size_t most, Key from, Key end,
                    std::span<const Seen> seen, std::vector<Key>& gone) {
  gone.clear();
  auto next = seen.begin();
  for (auto at = known.lower_bound(from); at != known.end() && at->first < end;) {
    while (next != seen.end() && key(*next) < at->first) ++next;
    if (next != seen.end() && key(*next) == at->first) {
      ++at;
    } else {
      gone.push_back(at->first);
      at = known.erase(at);
    }
  }
  std::uint64_t left_out = 0;
  for (const Seen& one : seen) {
    const auto at = known.find(key(one));
    if (at != known.end())
      at->second = one;
    else if (known.size() < most)
      known.emplace(key(one), one);
    else
      ++left_out;
  }
  return left_out;
}

}  // namespace

void ObservedScene::take(const SceneView& view) {
  robots_gone_.clear();
  const unsigned seats = view.robot ? view.robot->seats : 0;
  std::erase_if(robots_, [&](const auto& known) {
    const bool gone = (seats >> known.first & 1u) == 0;
    if (gone) robots_gone_.push_back(known.first);
    return gone;
  });
  if (view.robot) robots_[view.robot->seat] = *view.robot;
  left_out_ +=
      renew(hands_, kMostHands, view.hands_from, view.hands_end, view.hands(), hands_gone_);
  left_out_ +=
      renew(bodies_, kMostBodies, view.bodies_from, view.bodies_end, view.bodies(), bodies_gone_);
}

}  // namespace feltwire
