// Describes a scene's sessions to observers, and its counters to admins.

#include <algorithm>

#include "server/scene/named_counters.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

control::SessionDescriptions SceneSessions::describe_after(std::uint32_t number,
                                                           Nanoseconds now) const {
  control::SessionDescriptions list;
  for (const auto& slot : slots_) {
    if (slot->number <= number) continue;
    if (list.sessions.size() == control::kMaxDescriptions) {
      list.more = true;
      break;
    }
    const Session& session = slot->session;
    const SessionCounters& counters = session.counters();
    control::SessionDescription entry;
    entry.number = slot->number;
    entry.session = slot->id;
    entry.client = session.client();
    entry.device = session.device().name;
    entry.tool = slot->tool;
    entry.role = slot->role;
    entry.parameters = session.parameters();
    entry.samples = counters.samples;
    entry.missed = counters.missed;
    entry.delivered = session.delivered().total();
    entry.burned = session.burned();
    if (const auto& report = session.report()) {
      if (report->round_trip > 0.0) entry.round_trip = report->round_trip;
      if (report->has_account) entry.balance = report->balance;
      if (report->hand_damping > 0.0) entry.hand_damping = report->hand_damping;
    }
    entry.seconds = std::max(seconds(now - slot->joined), 0.0);
    entry.times = session.times();
    entry.takes = slot->takes;
    entry.lead_share = slot->lead_share;
    if (slot->leads || slot->role == Role::follower) entry.seat = seat_name(slot->seat);
    if (slot->asked) {
      entry.asked = slot->asked->what;
      entry.answer = slot->asked->answer;
    }
    list.sessions.push_back(std::move(entry));
  }
  return list;
}

control::Counters SceneSessions::named_counters() const {
  const SceneCounters now = counters();
  control::Counters named;
  for (const auto& [counter, value] : feltwire::named_counters(now))
    named.counters.push_back({std::string(counter), value});
  for (std::size_t i = 1; i < now.drops.size(); ++i)
    named.counters.push_back(
        {std::string("dropped.") + name(static_cast<DropReason>(i)), now.drops[i]});
  return named;
}

}  // namespace feltwire
