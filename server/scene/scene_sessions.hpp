#pragma once
// All sessions of one scene: from the bytes of a datagram to those of its answer. It has no socket
// and no clock.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/session/profiles.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/seal.hpp"
#include "server/picture/picture.hpp"
#include "server/scene/admin_changes.hpp"
#include "server/scene/apply_live_change.hpp"
#include "server/scene/client_changes.hpp"
#include "server/scene/datagram_gate.hpp"
#include "server/scene/fair_share.hpp"
#include "server/scene/observer_views.hpp"
#include "server/scene/pace.hpp"
#include "server/scene/path_limits.hpp"
#include "server/scene/peer_address.hpp"
#include "server/scene/prefetched_surfaces.hpp"
#include "server/scene/robot_seats.hpp"
#include "server/scene/sample_handler.hpp"
#include "server/scene/scene_counters.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/served_scene.hpp"
#include "server/scene/session.hpp"
#include "server/scene/session_end.hpp"
#include "server/scene/session_limits.hpp"
#include "server/scene/session_table.hpp"
#include "server/scene/teleop_link.hpp"
#include "server/scene/world_clock.hpp"

namespace feltwire {

/// Wires the stages of a scene, each a class of its own. A datagram goes through WorldClock,
/// DatagramGate, SampleHandler with its Session, RobotSeats or ObserverViews, and SceneLog.
/// SessionTable has the sessions; AdminChanges, ClientChanges and PathLimits change them.
class SceneSessions {
 public:
  /// The scene must outlive this. A session that sends nothing for `silence_timeout` ends. With a
  /// `line` a session gets at most the rate that the line has room for.
  SceneSessions(const Scene& scene, Nanoseconds silence_timeout, std::size_t max_sessions,
                const NetworkProfile* line = nullptr, const SessionLimits& limits = {});
  // The stages refer to each other.
  SceneSessions(const SceneSessions&) = delete;
  SceneSessions& operator=(const SceneSessions&) = delete;

  /// Answers join, leave, set parameters, list sessions and counters; everything else is refused as
  /// malformed. `id` and `keys` are the new session's for a join, else unused. Impossible numbers
  /// give Refused.
  control::Message answer(const control::Message& request, std::uint64_t id,
                          const SessionKeys& keys, Nanoseconds now);

  /// Takes one datagram, with all checks of PROTOCOL.md in their order. The answer is sealed into
  /// `out`; empty if there is none. Never allocates.
  Bytes receive(Bytes datagram, const Peer& from, Nanoseconds now, DatagramBuffer& out) noexcept;

  /// Seats for robots in the scene.
  std::size_t seats() const noexcept { return seats_.size(); }
  /// Empty: the only seat, or there is no such seat.
  std::string seat_name(std::size_t seat) const { return seats_.name(seat); }
  /// The newest target of the robot on a seat, and its receiver; empty: none is due. Call it after
  /// receive(), once for all datagrams that came together, because older targets are useless. Never
  /// allocates. Precondition: seat < seats().
  Bytes forward(std::size_t seat, Nanoseconds now, Peer& to, DatagramBuffer& out) noexcept {
    return seats_.forward(seat, now, to, out);
  }
  /// The state between the robot on a seat and the hand that leads it. Precondition: as above.
  LinkState link_state(std::size_t seat) const noexcept { return seats_.state(seat); }

  /// Charges the time of all datagrams since the last call (FairShare). Never allocates.
  void spent(Nanoseconds time, Nanoseconds now) noexcept {
    share_.charge(time);
    share_.balance(now);
    pace_.adapt(table_.slots(), share_, now);
  }
  /// Charges time that no session caused, for example of a tick.
  void spent_otherwise(Nanoseconds time) noexcept { share_.charge_other(time); }
  const FairShare& share() const { return share_; }
  /// The sessions that send fewer datagrams because the thread is short of time.
  const Pace& pace() const noexcept { return pace_; }
  std::string pace_line(Nanoseconds now) { return pace_.line(table_.slots(), now); }
  /// The number of datagrams that were dropped because their session was above its share.
  std::uint64_t shed() const { return gate_.counters().shed; }

  /// Steps the moving objects up to `now`, with the push of each session. Every received datagram
  /// does the same. Time stops while there is no session. After a stall at most kMostTicks ticks
  /// are made up for, and the rest of the time is dropped. If that happens again and again, because
  /// a tick takes longer than it lasts, the limit is halved each time, so that hands wait for one
  /// tick and not for twenty. It allocates only if the contacts need more room than ever before
  /// (docs/moving.md).
  void tick(Nanoseconds now) noexcept;
  /// The time of the next step. Empty: no object moves, or there is no session.
  std::optional<Nanoseconds> next_tick() const {
    return table_.empty() ? std::nullopt : clock_.next_tick();
  }
  static constexpr int kMostTicks = WorldClock::kMostTicks;
  /// Steps of the world that were dropped because the server was too late.
  std::uint64_t ticks_dropped() const { return clock_.ticks_dropped(); }
  /// The world of the moving objects; null: nothing moves.
  const World* world() const { return clock_.world(); }

  using GoodbyeDatagram = feltwire::GoodbyeDatagram;
  /// Moves all sessions to another scene, in its initial state, with the tools that they requested;
  /// sessions whose tool it does not have end. Robots and hands that lead know the seats by their
  /// numbers: if it has other seats, by name and order, their sessions end. It must outlive this;
  /// the old scene is not used any more. Allocates; throws and changes nothing if there is no
  /// memory for it.
  std::vector<GoodbyeDatagram> enter(const Scene& scene, Nanoseconds now);

  /// Makes a change from the next sample on, or refuses it; a refused one changes nothing. Every
  /// live change of a scene and of its sessions comes through here, on the scene's thread and
  /// between two datagrams, and goes into the log. The scene in the result must outlive this.
  /// Allocates; throws std::bad_alloc and changes nothing if there is no memory for it.
  ChangeOutcome change(const LiveChange& change, Nanoseconds now) {
    return changes_.change(change, now);
  }
  /// The answers of clients to changes since the last call, one log line each. Allocates if there
  /// are any.
  std::vector<std::string> answers() { return client_changes_.answers(table_.slots()); }
  bool has_answers() const noexcept { return client_changes_.has_answers(); }
  /// The payload of a session's replies is at most so long from now on [bytes], because its path
  /// takes no longer ones: they carry less of the model or the view. After a minute longer ones are
  /// tried again. A session that does not exist is none of its business. Never allocates.
  void limit_replies(std::uint64_t id, std::size_t payload, Nanoseconds now) noexcept;
  /// Whether a session's replies have less room than that already, or there is no such session.
  bool is_limited(std::uint64_t id, std::size_t payload) noexcept;
  /// The sessions whose path was found to be short since the last call, one log line each.
  /// Allocates if there are any.
  std::vector<std::string> short_paths() { return paths_.short_paths(table_.slots()); }
  bool has_short_paths() const noexcept { return paths_.has_short_paths(); }
  /// [m/s^2] on moving objects; empty: nothing moves.
  std::optional<Vec3> gravity() const;

  /// Ends the sessions that were silent for too long, that flooded, that broke the simulation again
  /// and again, or under whose id too many foreign datagrams came.
  std::vector<GoodbyeDatagram> expire(Nanoseconds now) { return table_.expire(now); }
  /// Ends one session, if it exists.
  std::vector<GoodbyeDatagram> evict(std::uint64_t id) { return table_.evict(id); }
  /// Ends all sessions, because the server ends or failed in this scene. If there is no memory for
  /// a goodbye, a session gets none.
  std::vector<GoodbyeDatagram> shut_down() noexcept {
    return table_.end_all(GoodbyeReason::shutting_down);
  }
  std::vector<GoodbyeDatagram> fail() noexcept { return table_.end_all(GoodbyeReason::failed); }

  /// Sessions that have ended since forget_ended().
  const std::vector<EndedSession>& ended() const { return table_.ended(); }
  void forget_ended() noexcept { table_.forget_ended(); }

  /// The places of all hands and moving objects. May allocate; throws only std::bad_alloc.
  void draw(Picture& picture, Nanoseconds now) const { views_.draw(picture, now); }
  /// A description of each hand. Allocates.
  std::vector<HandDescription> describe() const { return table_.describe(); }
  /// All sessions with greater numbers, at most control::kMaxDescriptions. Allocates.
  control::SessionDescriptions describe_after(std::uint32_t number, Nanoseconds now) const {
    return table_.describe_after(number, now);
  }

  /// From now on, all inputs that decide a reply go into the log, which must outlive this; null:
  /// none. A log can be replayed only if it began before the first session.
  void log_to(EventLog* log) noexcept { log_.log_to(log); }
  /// Logs the places of all moving objects, for a replay to compare. Never allocates.
  void check(Nanoseconds now) noexcept { log_.check(clock_.world(), now); }

  // For a replay (server/recording/scene_replay.hpp).
  /// Does the work of receive() for the payload of an accepted datagram. Returns the payload of the
  /// answer; empty if there is no answer or no such session.
  Bytes replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept;
  /// Ends a session, if it exists, without a goodbye.
  void replay_end(std::uint64_t id, SessionEnd how) noexcept;
  /// The client of a session, if it exists, was asked for this pace.
  void replay_pace(std::uint64_t id, std::uint8_t intervals, Nanoseconds now) noexcept;

  /// Counts the scenes, from 1: one more with each enter().
  std::uint32_t scene_version() const noexcept { return served_.version; }
  /// Live changes of materials and gravity so far.
  std::uint32_t live_changes() const noexcept { return served_.live_changes; }

  std::size_t size() const { return table_.size(); }
  /// Running sessions included.
  SceneCounters counters() const {
    return {table_.counters(), gate_.counters(), clock_.counters(), pace_.counters()};
  }
  const Session* find(std::uint64_t id);

 private:
  void say_goodbye(SessionSlot& slot, Bytes payload) noexcept;

  ServedScene served_;
  SceneLog log_;
  WorldClock clock_;
  RobotSeats seats_;
  FairShare share_;
  SessionTable table_;
  DatagramGate gate_;
  PathLimits paths_;
  Pace pace_;
  ClientChanges client_changes_;
  ObserverViews views_;
  AdminChanges changes_;
  SampleHandler samples_;
};

}  // namespace feltwire
