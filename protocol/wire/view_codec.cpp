#include "protocol/wire/view_codec.hpp"

#include <algorithm>
#include <cmath>

#include "protocol/wire/aligned_vector.hpp"

namespace feltwire {
namespace {

static_assert(sizeof(wire::SeenHand) == SceneView::kHandSize);
static_assert(sizeof(wire::SeenBody) == SceneView::kBodySize);
static_assert(sizeof(wire::HandFigures) == SceneView::kFiguresSize);

// kSeenRobotRoom includes 12 bytes for a table entry and for padding.
static_assert(sizeof(wire::SeenRobot) <= kSeenRobotRoom - 12);

constexpr std::uint32_t kSensed = 1u << 0, kWell = 1u << 1, kStopped = 1u << 2, kTouches = 1u << 3;
constexpr int kSeat = 8, kSeats = 16;  // first bits of the fields `seat` and `seats`
constexpr std::uint32_t kAllSeats = (1u << kMostSeats) - 1;
constexpr std::uint16_t kReported = 1, kHasAccount = 2;  // flags of the figures

wire::SeenHand wire_seen(const SeenHand& hand) {
  return {wire_float(hand.pose.position), wire_float(hand.pose.orientation), wire_float(hand.force),
          hand.number};
}
wire::SeenBody wire_seen(const SeenBody& body) {
  return {wire_float(body.pose.position), wire_float(body.pose.orientation), body.object};
}

wire::HandFigures wire_figures(const HandFigures& f) {
  const HandReport report = f.report.value_or(HandReport{});
  const auto flags = static_cast<std::uint16_t>((f.report ? kReported : 0u) |
                                                (report.has_account ? kHasAccount : 0u));
  return {f.samples,
          f.missed,
          wire_float(f.proxy),
          wire_float(f.elastic),
          wire_float(f.frictional),
          float32(f.depth),
          float32(f.delivered),
          float32(f.burned),
          float32(report.balance),
          float32(report.round_trip),
          f.states,
          report.reasons,
          f.tool,
          flags,
          report.late_ticks};
}

SeenHand value(const wire::SeenHand& hand) {
  return {hand.number(),
          {feltwire::value(hand.position()), feltwire::value(hand.orientation())},
          feltwire::value(hand.force())};
}
HandFigures value(const wire::HandFigures& f) {
  HandFigures figures{.samples = f.samples(),
                      .missed = f.missed(),
                      .proxy = feltwire::value(f.proxy()),
                      .elastic = feltwire::value(f.elastic()),
                      .frictional = feltwire::value(f.frictional()),
                      .depth = static_cast<double>(f.depth()),
                      .delivered = static_cast<double>(f.delivered()),
                      .burned = static_cast<double>(f.burned()),
                      .states = f.states(),
                      .report = {},
                      .tool = f.tool()};
  if ((f.flags() & kReported) != 0)
    figures.report = HandReport{.reasons = f.reasons() & kAllHandReasons,
                                .has_account = (f.flags() & kHasAccount) != 0,
                                .balance = static_cast<double>(f.balance()),
                                .round_trip = static_cast<double>(f.round_trip()),
                                .late_ticks = f.late_ticks()};
  return figures;
}
SeenBody value(const wire::SeenBody& body) {
  return {body.object(), {feltwire::value(body.position()), feltwire::value(body.orientation())}};
}

wire::SeenRobot wire_seen(const SeenRobot& r) {
  const std::uint32_t flags = (r.force ? kSensed : 0) | (r.ok ? kWell : 0) |
                              (r.stopped ? kStopped : 0) | (r.touches ? kTouches : 0) |
                              std::uint32_t{r.seat} << kSeat | std::uint32_t{r.seats} << kSeats;
  return {wire_float(r.pose.position),
          wire_float(r.pose.orientation),
          wire_float(r.target.position),
          wire_float(r.target.orientation),
          wire_float(r.force.value_or(Vec3::Zero())),
          wire_float(r.torque),
          static_cast<std::uint32_t>(r.state),
          r.hand,
          flags,
          float32(r.gripper),
          float32(r.age)};
}

std::uint32_t place(const SeenHand& hand) { return hand.number; }
std::uint32_t place(const SeenBody& body) { return body.object; }

bool finite(const Pose& pose) {  // A NaN is not finite.
  return pose.position.allFinite() &&
         std::abs(pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
}
bool finite(const SeenHand& hand) { return finite(hand.pose) && hand.force.allFinite(); }
bool finite(const SeenBody& body) { return finite(body.pose); }
bool finite(const HandFigures& f) {
  return f.proxy.allFinite() && f.elastic.allFinite() && f.frictional.allFinite() &&
         std::isfinite(f.depth) && std::isfinite(f.delivered) && std::isfinite(f.burned) &&
         (!f.report || f.report->finite());
}

DropReason read(const wire::SeenRobot& from, SeenRobot& to) noexcept {
  if (from.state() > static_cast<std::uint32_t>(kLastLinkState)) return DropReason::not_finite;
  to = {.pose = {feltwire::value(from.position()), feltwire::value(from.orientation())},
        .target = {feltwire::value(from.target()), feltwire::value(from.target_turn())},
        .torque = feltwire::value(from.torque()),
        .state = static_cast<LinkState>(from.state()),
        .hand = from.hand(),
        .ok = (from.flags() & kWell) != 0,
        .stopped = (from.flags() & kStopped) != 0,
        .touches = (from.flags() & kTouches) != 0,
        .gripper = static_cast<double>(from.gripper()),
        .age = static_cast<double>(from.age()),
        .seat = static_cast<std::uint8_t>(from.flags() >> kSeat & 0xff),
        .seats = static_cast<std::uint8_t>(from.flags() >> kSeats & kAllSeats)};
  if ((from.flags() & kSensed) != 0) to.force = feltwire::value(from.force());
  const bool good = finite(to.pose) && finite(to.target) && (!to.force || to.force->allFinite()) &&
                    to.torque.allFinite() && std::isfinite(to.gripper) && to.age >= 0.0 &&
                    std::isfinite(to.age) && to.seat < kMostSeats && (to.seats >> to.seat & 1) != 0;
  return good ? DropReason::none : DropReason::not_finite;
}

/// Reads a list of hands or bodies. Their numbers must ascend within [begin, end).
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

/// Reads the figures of the hands in `view`.
DropReason read_figures(const flatbuffers::Vector<const wire::HandFigures*>& from,
                        SceneView& view) noexcept {
  if (!aligned(from, alignof(wire::HandFigures))) return DropReason::malformed;
  if (from.size() != view.hand_count || view.hand_count > SceneView::kMaxFigures)
    return DropReason::count;
  DropReason wrong = DropReason::none;
  for (std::size_t i = 0; i < view.hand_count; ++i) {
    view.hand[i].figures = value(*from.Get(static_cast<flatbuffers::uoffset_t>(i)));
    if (!finite(*view.hand[i].figures)) wrong = DropReason::not_finite;
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
  flatbuffers::Offset<flatbuffers::Vector<const wire::HandFigures*>> figures;
  if (view.hand_count > 0 && view.hand.front().figures) {
    std::array<wire::HandFigures, SceneView::kMaxFigures> known;
    const std::size_t count = std::min(view.hand_count, known.size());
    for (std::size_t i = 0; i < count; ++i)
      known[i] = wire_figures(view.hand[i].figures.value_or(HandFigures{}));
    figures = builder.CreateVectorOfStructs(known.data(), count);
  }
  const wire::SeenRobot robot = view.robot ? wire_seen(*view.robot) : wire::SeenRobot();
  return wire::CreateSceneView(builder, view.hands_from, view.hands_end, view.bodies_from,
                               view.bodies_end, seen_hands, seen_bodies, figures,
                               view.robot ? &robot : nullptr);
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
  out.robot.reset();
  const DropReason robot =
      from.robot() == nullptr ? DropReason::none : read(*from.robot(), out.robot.emplace());
  const DropReason seen = first_of(first_of(hands, bodies), robot);
  if (from.figures() == nullptr || hands == DropReason::count) return seen;
  return first_of(seen, read_figures(*from.figures(), out));
}

}  // namespace feltwire
