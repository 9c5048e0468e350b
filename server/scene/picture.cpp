#include "server/scene/picture.hpp"

#include <algorithm>
#include <array>

#include "server/scene/session_slot.hpp"

namespace feltwire {
namespace {

struct StateText {
  const char* name;
  bool takes_off;
  const char* text;
};
constexpr std::array<StateText, kHandStates> kStates = {{
    {"waiting", false, "No sample of this hand has come yet."},
    {"silent", true,
     "Nothing has come from this hand for longer than its hold time, so its force has faded."},
    {"free_space", false, "The tool touches nothing."},
    {"touching", false, "The scene asks for a force."},
    {"gap", false, "Samples were lost on the way."},
    {"server_bound", true, "The server's energy bound takes something off the force."},
    {"saturated", true, "The scene asks for more than the device's largest force."},
    {"refused", true, "The movement was out of range, so no force was computed."},
    {"recovering", true, "Moving objects were put back to a good state and are felt in part."},
    {"client_less", true,
     "The device holds less than the scene asks for: the client's energy bound, its account or one "
     "of its limits takes something off."},
}};

constexpr double kSmallForce = 0.01;  // [N] less is no force
constexpr double kMuchLess = 0.9;     // share of the force asked for

std::uint32_t states_of(const Session& session, bool recovering, bool silent) noexcept {
  if (session.newest().index == 0) return bit(HandState::waiting);
  const SampleOutcome& outcome = session.outcome();
  const double asked = outcome.asked.force().norm();
  const double held = session.newest().held.force().norm();
  std::uint32_t states = bit(asked > kSmallForce ? HandState::touching : HandState::free_space);
  const auto put = [&](HandState state, bool holds) {
    if (holds) states |= bit(state);
  };
  put(HandState::silent, silent);
  put(HandState::gap, outcome.gap);
  put(HandState::server_bound, outcome.bounded);
  put(HandState::saturated, outcome.saturated || asked > session.device().max_force);
  put(HandState::refused, outcome.refused);
  put(HandState::recovering, recovering);
  put(HandState::client_less, !session.report() && asked > kSmallForce && held < kMuchLess * asked);
  return states;
}

}  // namespace

const char* name(HandState state) noexcept { return kStates[static_cast<std::size_t>(state)].name; }
const char* text(HandState state) noexcept { return kStates[static_cast<std::size_t>(state)].text; }
bool takes_off(HandState state) noexcept {
  return kStates[static_cast<std::size_t>(state)].takes_off;
}

void SceneSessions::draw(Picture& picture, Nanoseconds now) const {
  picture.time = now;
  picture.hands.clear();
  picture.bodies.clear();
  const bool recovering = world_ != nullptr && world_->recovering();
  for (const auto& slot : slots_) {
    const Session& session = slot->session;
    if (session.observes()) continue;
    PictureHand hand;
    hand.number = slot->number;
    const double age = seconds(now - slot->last_heard);
    hand.states = states_of(session, recovering, age > session.parameters().hold_time);
    hand.samples = session.counters().samples;
    hand.missed = session.counters().missed;
    hand.report = session.report();
    if (session.newest().index != 0) {
      const ProxyPlace proxy = session.proxy();
      hand.pose = session.newest().pose;
      hand.proxy = proxy.position;
      hand.depth = proxy.depth;
      hand.elastic = session.outcome().asked.elastic;
      hand.frictional = session.outcome().asked.frictional;
      hand.held = session.newest().held.force();
      hand.delivered = session.delivered().total();
      hand.burned = session.burned();
      if (picture.hands.size() < kMostPictureSurfaces) hand.surfaces = session.surfaces();
    }
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
      hands.push_back({slot->number, slot->id, session.client(), session.device().name, slot->tool,
                       session.parameters()});
  return hands;
}

}  // namespace feltwire
