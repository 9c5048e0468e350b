#include "server/scene/scene_sessions.hpp"

#include <memory>
#include <utility>
#include <variant>

namespace feltwire {

SceneSessions::SceneSessions(const Scene& scene, Nanoseconds silence_timeout,
                             std::size_t max_sessions, const NetworkProfile* line,
                             const SessionLimits& limits)
    : served_{&scene},
      share_(max_sessions),
      table_({.silence_timeout = silence_timeout,
              .max_sessions = max_sessions,
              .line = line,
              .session = limits},
             served_, clock_, seats_, share_, log_),
      gate_(table_.ids(), share_),
      paths_(log_),
      pace_(limits.slow_down, log_),
      views_(served_, table_, seats_, clock_),
      changes_(served_, clock_, table_, seats_, log_),
      samples_(gate_, seats_, client_changes_, paths_, views_, log_) {
  clock_.run(WorldClock::world_of(scene), Nanoseconds{0});
  seats_.take_over(seats_.seats_of(scene, clock_.world()));
}

Bytes SceneSessions::receive(Bytes datagram, const Peer& from, Nanoseconds now,
                             DatagramBuffer& out) noexcept {
  tick(now);
  const Admitted admitted = gate_.admit(datagram, now);
  SessionSlot* const slot = admitted.session;
  if (slot == nullptr) return {};
  switch (admitted.kind) {
    case DatagramKind::goodbye:
      say_goodbye(*slot, admitted.payload);
      return {};
    case DatagramKind::follower_state:
      samples_.take_state(*slot, admitted.payload, {from, admitted.newest, now});
      return {};
    default: {
      const Bytes answer = samples_.answer(*slot, admitted.payload, {from, admitted.newest, now});
      return answer.empty() ? answer
                            : slot->sealer.seal(DatagramKind::reply, slot->id, answer, out);
    }
  }
}

/// Ends the session if the payload is a valid goodbye of its client.
void SceneSessions::say_goodbye(SessionSlot& slot, Bytes payload) noexcept {
  GoodbyeReason reason;
  if (gate_.read(payload, reason)) table_.leave(slot, SessionEnd::goodbye);
}

Bytes SceneSessions::replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept {
  SessionSlot* const slot = table_.find(id);
  if (slot == nullptr) return {};
  const Origin origin{Peer{}, true, now};
  if (slot->role != Role::follower) return samples_.answer(*slot, payload, origin);
  samples_.take_state(*slot, payload, origin);
  return {};
}

void SceneSessions::replay_end(std::uint64_t id, SessionEnd how) noexcept {
  if (SessionSlot* const slot = table_.find(id)) table_.end(*slot, how);
}

void SceneSessions::replay_pace(std::uint64_t id, std::uint8_t intervals,
                                Nanoseconds now) noexcept {
  if (SessionSlot* const slot = table_.find(id)) pace_.set(*slot, intervals, now);
}

void SceneSessions::tick(Nanoseconds now) noexcept {
  if (table_.empty() || !clock_.is_due(now)) return;
  log_.put({.kind = EventKind::tick, .time = now});
  clock_.tick(now, table_.slots(), seats_.seats());
}

control::Message SceneSessions::answer(const control::Message& request, std::uint64_t id,
                                       const SessionKeys& keys, Nanoseconds now) {
  if (const auto* wanted = std::get_if<control::JoinRequest>(&request))
    return table_.join(*wanted, id, keys, now);
  if (const auto* wanted = std::get_if<control::LeaveRequest>(&request)) {
    SessionSlot* const slot = table_.find(wanted->session);
    if (slot == nullptr) return unknown_session(wanted->session);
    table_.leave(*slot, SessionEnd::asked);
    return control::Left{wanted->session};
  }
  if (const auto* wanted = std::get_if<control::SetParameters>(&request)) {
    auto outcome = change(ParameterChange{wanted->session, wanted->parameters}, now);
    if (auto* refused = std::get_if<control::Refused>(&outcome)) return std::move(*refused);
    return control::ParametersSet{wanted->session, find(wanted->session)->parameters()};
  }
  if (const auto* wanted = std::get_if<control::TakeSurfaces>(&request))
    return changes_.take_surfaces(*wanted, now);
  if (std::holds_alternative<control::DescribeScene>(request)) {
    control::SceneDescription described;
    described.times.world_late = clock_.world_late();
    return described;
  }
  if (const auto* wanted = std::get_if<control::DescribeSessions>(&request))
    return describe_after(wanted->after, now);
  if (std::holds_alternative<control::GetCounters>(request)) return counter_list(counters());
  return control::Refused{control::RefusalCode::malformed,
                          "a scene answers join, leave, set parameters, take surfaces, and lists "
                          "of its sessions and counters only"};
}

std::vector<GoodbyeDatagram> SceneSessions::enter(const Scene& scene, Nanoseconds now) {
  // Make all calls that may throw before the first change.
  std::unique_ptr<World> world = WorldClock::world_of(scene);
  std::vector<RobotSeat> seats = seats_.seats_of(scene, world.get());
  SessionTable::Moves moves = table_.moves_to(scene, world.get(), seats_.is_same(scene));
  log_.announce(scene.files());

  // The sessions still refer to the previous world until carry_out().
  const auto before = clock_.run(std::move(world), now);
  seats_.take_over(std::move(seats));
  served_.scene = &scene;
  ++served_.version;
  log_.put({.kind = EventKind::reload, .time = now});
  table_.carry_out(moves);
  return std::move(moves.goodbyes);
}

void SceneSessions::limit_replies(std::uint64_t id, std::size_t payload, Nanoseconds now) noexcept {
  if (SessionSlot* const slot = table_.find(id)) paths_.limit(*slot, payload, now);
}

bool SceneSessions::is_limited(std::uint64_t id, std::size_t payload) noexcept {
  SessionSlot* const slot = table_.find(id);
  return slot == nullptr || slot->path.room < payload;
}

std::optional<Vec3> SceneSessions::gravity() const {
  if (clock_.world() == nullptr) return std::nullopt;
  return clock_.world()->gravity();
}

const Session* SceneSessions::find(std::uint64_t id) {
  SessionSlot* const slot = table_.find(id);
  return slot == nullptr ? nullptr : &slot->session;
}

}  // namespace feltwire
