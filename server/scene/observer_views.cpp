#include "server/scene/observer_views.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

constexpr double kSmallForce = 0.01;  // [N] a smaller force counts as zero
// A hand whose client sends no reports is `client_less` if the force that it holds is below this
// share of the commanded force.
constexpr double kMuchLess = 0.9;

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

/// Limits a value so that it fits into a float32. Returns 0 if it is not finite.
double shown(double value) noexcept {
  constexpr double kMost = 1e12;
  return std::isfinite(value) ? std::clamp(value, -kMost, kMost) : 0.0;
}
Vec3 shown(const Vec3& v) noexcept { return {shown(v.x()), shown(v.y()), shown(v.z())}; }

/// Returns the index of the tool among the scene's tools; 0 if the scene does not have it.
std::uint16_t tool_index(const Scene& scene, const std::string& tool) noexcept {
  const std::vector<ToolView>& views = scene.views();
  const auto found =
      std::ranges::find(views, tool, [](const ToolView& view) { return view.tool().name; });
  return static_cast<std::uint16_t>(found == views.end() ? 0 : found - views.begin());
}

HandFigures figures_of(const PictureHand& hand, std::uint16_t tool) noexcept {
  return {.samples = hand.samples,
          .missed = hand.missed,
          .proxy = shown(hand.proxy),
          .elastic = shown(hand.elastic),
          .frictional = shown(hand.frictional),
          .depth = shown(hand.depth),
          .delivered = shown(hand.delivered),
          .burned = shown(hand.burned),
          .states = hand.states,
          .report = hand.report,
          .tool = tool};
}

}  // namespace

const SceneView& ObserverViews::next(SessionSlot& observer, std::size_t room,
                                     Nanoseconds now) noexcept {
  const bool figures = observer.observer.figures;
  const std::size_t hand_size =
      SceneView::kHandSize + (figures ? SceneView::kFiguresSize + kFiguresOverhead : 0);
  // If `room` is too small for a robot and a hand, the replies show them alternately.
  const bool both = room >= kSeenRobotRoom + hand_size;
  view_.robot.reset();
  if (both || observer.session.counters().replies % 2 == 0)
    view_.robot = seats_.next_seen(observer, now);
  if (view_.robot) room -= std::min(room, kSeenRobotRoom);
  ObserverView& progress = observer.observer.view;
  if (figures && room >= hand_size) {
    progress.show(table_.hands(), clock_.world(), room - kFiguresOverhead, view_,
                  SceneView::kHandSize + SceneView::kFiguresSize);
    add_figures(now);
  } else {
    progress.show(table_.hands(), clock_.world(), room, view_);
  }
  return view_;
}

/// Returns the state of a hand for a picture of the scene, without the surfaces near the hand.
PictureHand ObserverViews::picture_of(const SessionSlot& slot, Nanoseconds now) const noexcept {
  const Session& session = slot.session;
  PictureHand hand;
  hand.number = slot.number;
  const double age = seconds(now - slot.last_heard);
  hand.states = states_of(session, clock_.is_recovering(), age > session.parameters().hold_time,
                          seats_.moves_robot(slot));
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

/// Adds measured values (HandFigures) to each hand in view_.
void ObserverViews::add_figures(Nanoseconds now) noexcept {
  const SessionSlots& slots = table_.slots();
  for (std::size_t i = 0; i < view_.hand_count; ++i) {
    SeenHand& seen = view_.hand[i];
    const auto slot =
        std::ranges::find(slots, seen.number, [](const auto& entry) { return entry->number; });
    if (slot == slots.end()) continue;
    seen.figures = figures_of(picture_of(**slot, now), tool_index(*served_.scene, (*slot)->tool));
  }
}

void ObserverViews::draw(Picture& picture, Nanoseconds now) const {
  picture.time = now;
  picture.hands.clear();
  picture.bodies.clear();
  picture.robots.clear();
  for (std::size_t seat = 0; seat < seats_.size(); ++seat)
    if (const auto robot = seats_.seen(seat, now)) picture.robots.push_back(*robot);
  for (const auto& slot : table_.slots()) {
    const Session& session = slot->session;
    if (session.observes()) continue;
    PictureHand hand = picture_of(*slot, now);
    if (session.newest().index != 0 && picture.hands.size() < kMostPictureSurfaces)
      hand.surfaces = session.surfaces();
    picture.hands.push_back(hand);
  }
  const World* const world = clock_.world();
  if (world == nullptr) return;
  const std::vector<Object>& objects = world->objects();
  for (std::size_t i = world->view().still(); i < objects.size(); ++i)
    picture.bodies.push_back({static_cast<std::uint32_t>(i), objects[i].pose});
}

}  // namespace feltwire
