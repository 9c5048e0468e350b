// The picture that a scene's thread draws of its sessions.

#include <algorithm>
#include <cmath>

#include "server/picture/picture.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

constexpr double kSmallForce = 0.01;  // [N] smaller forces count as none
constexpr double kMuchLess = 0.9;     // share of the force asked for

std::uint32_t states_of(const Session& session, bool recovering, bool silent,
                        bool moves_robot) noexcept {
  if (session.newest().index == 0) return bit(HandState::waiting);
  const SampleOutcome& outcome = session.outcome();
  const double asked = outcome.asked.force().norm();
  const double held = session.newest().held.force().norm();
  std::uint32_t states = 0;
  const auto put = [&](HandState state, bool holds) {
    if (holds) states |= bit(state);
  };
  put(HandState::touching, asked > kSmallForce);
  put(HandState::free_space, !(asked > kSmallForce) && !moves_robot);
  put(HandState::moves_robot, moves_robot);
  put(HandState::silent, silent);
  put(HandState::gap, outcome.gap);
  put(HandState::server_bound, outcome.bounded);
  put(HandState::saturated, outcome.saturated || asked > session.device().max_force);
  put(HandState::refused, outcome.refused);
  put(HandState::recovering, recovering);
  put(HandState::client_less, !session.report() && asked > kSmallForce && held < kMuchLess * asked);
  return states;
}

/// Clamps to numbers that fit into float32, whatever a hand causes.
double shown(double value) noexcept {
  constexpr double kMost = 1e12;
  return std::isfinite(value) ? std::clamp(value, -kMost, kMost) : 0.0;
}
Vec3 shown(const Vec3& v) noexcept { return {shown(v.x()), shown(v.y()), shown(v.z())}; }

}  // namespace

/// The picture of a hand without the surfaces near it.
PictureHand SceneSessions::picture_of(const SessionSlot& slot, Nanoseconds now) const noexcept {
  const Session& session = slot.session;
  const bool recovering = world_ != nullptr && world_->recovering();
  PictureHand hand;
  hand.number = slot.number;
  const double age = seconds(now - slot.last_heard);
  const bool moves_robot = slot.seat < seats_.size() && seats_[slot.seat].link.engages(slot.number);
  hand.states = states_of(session, recovering, age > session.parameters().hold_time, moves_robot);
  hand.samples = session.counters().samples;
  hand.missed = session.counters().missed;
  hand.report = session.report();
  if (session.newest().index == 0) return hand;
  const ProxyPlace proxy = session.proxy();
  hand.pose = session.newest().pose;
  hand.proxy = proxy.position;
  hand.depth = proxy.depth;
  hand.elastic = session.outcome().asked.elastic;
  hand.frictional = session.outcome().asked.frictional;
  hand.held = session.newest().held.force();
  hand.delivered = session.delivered().total();
  hand.burned = session.burned();
  return hand;
}

/// Adds the figures of the hands in the view.
void SceneSessions::add_figures(SceneView& view, Nanoseconds now) const noexcept {
  for (std::size_t i = 0; i < view.hand_count; ++i) {
    const auto slot = std::ranges::find(slots_, view.hand[i].number,
                                        [](const auto& entry) { return entry->number; });
    if (slot == slots_.end()) continue;
    const PictureHand hand = picture_of(**slot, now);
    const auto tool = std::ranges::find(scene_->views(), (*slot)->tool,
                                        [](const ToolView& seen) { return seen.tool().name; });
    const auto place = tool == scene_->views().end() ? 0 : tool - scene_->views().begin();
    view.hand[i].figures = HandFigures{.samples = hand.samples,
                                       .missed = hand.missed,
                                       .proxy = shown(hand.proxy),
                                       .elastic = shown(hand.elastic),
                                       .frictional = shown(hand.frictional),
                                       .depth = shown(hand.depth),
                                       .delivered = shown(hand.delivered),
                                       .burned = shown(hand.burned),
                                       .states = hand.states,
                                       .report = hand.report,
                                       .tool = static_cast<std::uint16_t>(place)};
  }
}

void SceneSessions::draw(Picture& picture, Nanoseconds now) const {
  picture.time = now;
  picture.hands.clear();
  picture.bodies.clear();
  picture.robots.clear();
  for (std::size_t seat = 0; seat < seats_.size(); ++seat)
    if (const auto robot = seen_robot(seat, now)) picture.robots.push_back(*robot);
  for (const auto& slot : slots_) {
    const Session& session = slot->session;
    if (session.observes()) continue;
    PictureHand hand = picture_of(*slot, now);
    if (session.newest().index != 0 && picture.hands.size() < kMostPictureSurfaces)
      hand.surfaces = session.surfaces();
    picture.hands.push_back(hand);
  }
  if (world_ == nullptr) return;
  const std::vector<Object>& objects = world_->objects();
  for (std::size_t i = world_->view().still(); i < objects.size(); ++i)
    picture.bodies.push_back({static_cast<std::uint32_t>(i), objects[i].pose});
}

std::vector<HandDescription> SceneSessions::describe() const {
  std::vector<HandDescription> hands;
  for (const auto& slot : slots_)
    if (const Session& session = slot->session; !session.observes())
      hands.push_back(
          {slot->number, slot->id, session.client(), session.device().name, slot->tool,
           session.parameters(), slot->takes, slot->asked ? slot->asked->what : std::string(),
           slot->asked ? slot->asked->answer : ChangeAnswer::waiting, session.times(),
           !seats_.empty() && covers(slot->role, Role::operator_) ? std::optional(slot->lead_share)
                                                                  : std::nullopt,
           slot->joined});
  return hands;
}

}  // namespace feltwire
