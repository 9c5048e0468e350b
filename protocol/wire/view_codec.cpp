#include "protocol/wire/view_codec.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

static_assert(sizeof(wire::SeenHand) == SceneView::kHandSize);
static_assert(sizeof(wire::SeenBody) == SceneView::kBodySize);

wire::SeenHand wire_seen(const SeenHand& hand) {
  return {wire_float(hand.pose.position), wire_float(hand.pose.orientation), wire_float(hand.force),
          hand.number};
}
wire::SeenBody wire_seen(const SeenBody& body) {
  return {wire_float(body.pose.position), wire_float(body.pose.orientation), body.object};
}

SeenHand value(const wire::SeenHand& hand) {
  return {hand.number(),
          {feltwire::value(hand.position()), feltwire::value(hand.orientation())},
          feltwire::value(hand.force())};
}
SeenBody value(const wire::SeenBody& body) {
  return {body.object(), {feltwire::value(body.position()), feltwire::value(body.orientation())}};
}

std::uint32_t place(const SeenHand& hand) { return hand.number; }
std::uint32_t place(const SeenBody& body) { return body.object; }

bool finite(const Pose& pose) {  // written so that NaN fails
  return pose.position.allFinite() &&
         std::abs(pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
}
bool finite(const SeenHand& hand) { return finite(hand.pose) && hand.force.allFinite(); }
bool finite(const SeenBody& body) { return finite(body.pose); }

/// One of the two lists: in [begin, end), rising.
template <class Seen, class Wire, std::size_t most>
DropReason read(const flatbuffers::Vector<const Wire*>* from, std::uint32_t begin,
                std::uint32_t end, std::array<Seen, most>& out, std::size_t& count) noexcept {
  count = from == nullptr ? 0 : from->size();
  if (count > most) return DropReason::count;
  DropReason wrong = DropReason::none;
  std::uint32_t least = begin;
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = value(*from->Get(static_cast<flatbuffers::uoffset_t>(i)));
    const std::uint32_t at = place(out[i]);
    if (at < least || at >= end) return DropReason::order;
    least = at + 1;
    if (!finite(out[i])) wrong = DropReason::not_finite;
  }
  return wrong;
}

}  // namespace

flatbuffers::Offset<wire::SceneView> build(flatbuffers::FlatBufferBuilder& builder,
                                           const SceneView& view) {
  std::array<wire::SeenHand, SceneView::kMaxHands> hands;
  std::array<wire::SeenBody, SceneView::kMaxBodies> bodies;
  std::ranges::transform(view.hands(), hands.begin(),
                         [](const SeenHand& hand) { return wire_seen(hand); });
  std::ranges::transform(view.bodies(), bodies.begin(),
                         [](const SeenBody& body) { return wire_seen(body); });
  flatbuffers::Offset<flatbuffers::Vector<const wire::SeenHand*>> seen_hands;
  flatbuffers::Offset<flatbuffers::Vector<const wire::SeenBody*>> seen_bodies;
  if (view.hand_count > 0)
    seen_hands = builder.CreateVectorOfStructs(hands.data(), view.hand_count);
  if (view.body_count > 0)
    seen_bodies = builder.CreateVectorOfStructs(bodies.data(), view.body_count);
  return wire::CreateSceneView(builder, view.hands_from, view.hands_end, view.bodies_from,
                               view.bodies_end, seen_hands, seen_bodies);
}

DropReason read(const wire::SceneView& from, SceneView& out) noexcept {
  out.present = true;
  out.hands_from = from.hands_from();
  out.hands_end = from.hands_end();
  out.bodies_from = from.bodies_from();
  out.bodies_end = from.bodies_end();
  const DropReason hands =
      read(from.hands(), out.hands_from, out.hands_end, out.hand, out.hand_count);
  const DropReason bodies =
      read(from.bodies(), out.bodies_from, out.bodies_end, out.body, out.body_count);
  return first_of(hands, bodies);
}

}  // namespace feltwire
