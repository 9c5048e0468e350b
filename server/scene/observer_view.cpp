#include "server/scene/observer_view.hpp"

#include <algorithm>

#include "core/scene/mechanism.hpp"

namespace feltwire {
namespace {

/// Returns the force that the client reported, limited so that it fits into a float32: a client may
/// report any number.
Vec3 shown_force(const Vec3& force) {
  constexpr double kMostForce = 1e12;  // [N] limit on each axis
  return force.cwiseMax(-kMostForce).cwiseMin(kMostForce);
}

}  // namespace

void ObserverView::show(std::span<const ActingHand> hands, const World* world, std::size_t room,
                        SceneView& view, std::size_t hand_size) noexcept {
  view.present = true;
  view.hands_from = view.hands_end = 0;
  view.bodies_from = view.bodies_end = 0;
  view.hand_count = view.body_count = 0;
  if (!hands_shown_) room -= show_hands(hands, room, view, hand_size);
  if (hands_shown_) show_bodies(world, room, view);
}

/// Adds the next hands to the view. Returns their size in the datagram [bytes].
std::size_t ObserverView::show_hands(std::span<const ActingHand> hands, std::size_t room,
                                     SceneView& view, std::size_t hand_size) noexcept {
  const std::size_t most = std::min(room / hand_size, SceneView::kMaxHands);
  auto next = std::ranges::lower_bound(hands, next_hand_, {}, &ActingHand::number);
  view.hands_from = next_hand_;
  for (; next != hands.end(); ++next) {
    const Sample& sample = next->session->newest();
    if (sample.index == 0) continue;
    if (view.hand_count == most) break;
    view.hand[view.hand_count++] = {next->number, sample.pose, shown_force(sample.held.force()),
                                    std::nullopt};
  }
  hands_shown_ = next == hands.end();
  view.hands_end = hands_shown_ ? SceneView::kLastHand : next->number;
  next_hand_ = hands_shown_ ? 0 : next->number;
  return view.hand_count * hand_size;
}

void ObserverView::show_bodies(const World* world, std::size_t room, SceneView& view) noexcept {
  const std::size_t most = std::min(room / SceneView::kBodySize, SceneView::kMaxBodies);
  std::size_t next = next_body_, end = next_body_;
  if (world != nullptr) {
    next = std::max(next, world->view().still());
    end = std::min<std::size_t>(world->objects().size(), SceneView::kLastBody);
  }
  view.bodies_from = next_body_;
  for (; next < end && view.body_count < most; ++next)
    view.body[view.body_count++] = {static_cast<std::uint16_t>(next), world->objects()[next].pose};
  const bool all = next >= end;
  view.bodies_end = all ? SceneView::kLastBody : static_cast<std::uint16_t>(next);
  next_body_ = all ? 0 : view.bodies_end;
  hands_shown_ = !all;
}

}  // namespace feltwire
