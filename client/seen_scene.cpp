#include "client/seen_scene.hpp"

#include <span>

namespace feltwire {
namespace {

std::uint32_t key(const SeenHand& hand) { return hand.number; }
std::uint16_t key(const SeenBody& body) { return body.object; }

/// Both rise, so that one walk along the two finds who is missing.
template <class Key, class Seen>
void renew(std::map<Key, Seen>& known, Key from, Key end, std::span<const Seen> seen,
           std::vector<Key>& gone) {
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
  for (const Seen& one : seen) known[key(one)] = one;
}

}  // namespace

void SeenScene::take(const SceneView& view) {
  renew(hands_, view.hands_from, view.hands_end, view.hands(), hands_gone_);
  renew(bodies_, view.bodies_from, view.bodies_end, view.bodies(), bodies_gone_);
}

}  // namespace feltwire
