#pragma once
// All sessions of one scene: from the bytes of a datagram to those of its answer. It has no socket
// and no clock.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/time_counts.hpp"
#include "protocol/session/profiles.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"
#include "server/picture/picture.hpp"
#include "server/scene/apply_live_change.hpp"
#include "server/scene/fair_share.hpp"
#include "server/scene/id_map.hpp"
#include "server/scene/observer_view.hpp"
#include "server/scene/peer_address.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/session.hpp"
#include "server/scene/session_end.hpp"
#include "server/scene/session_limits.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/teleop_link.hpp"
#include "server/scene/world_arm.hpp"

namespace feltwire {

struct SceneCounters {
  std::uint64_t sessions_served = 0;
  // Ended sessions by cause: goodbye or request, silence, flooding, too many forgeries, an admin or
  // an invalid token or a missing tool.
  std::uint64_t left = 0, silent = 0, flooded = 0, forged = 0, evicted = 0;
  std::uint64_t disturbing = 0;     // also ended, because they broke the simulation again and again
  std::uint64_t failed = 0;         // also ended, because the server failed in this scene
  std::uint64_t datagrams = 0;      // received
  std::uint64_t late_goodbyes = 0;  // of these, under the number of a session that has just ended
  SessionCounters samples;          // over all sessions
  WorldCounters world;              // zero if nothing moves
  std::uint64_t ticks_dropped = 0;  // of the world, when the thread could not keep up
  std::uint64_t shed =
      0;  // of the drops by rate, those of sessions above their share of the thread
  std::array<std::uint64_t, kDropReasons> drops{};
  TimeCounts world_late;  // delay of each waking for the world after its time
  // Sums over all clients that report them, by the classes of HandTimes.
  HandTimesHeard::Totals client_wakeups{}, client_round_trips{};
};

/// A session that does not exist, or no longer.
control::Refused unknown_session(std::uint64_t id);
/// The scene was loaded again since, or what a client has of it in full was changed.
control::Refused other_version(std::uint32_t version);
/// The version of what clients with this tool have in full of the scene of `version` after so many
/// live `changes`.
std::uint32_t prefetched_version(const ToolView& view, std::uint32_t version,
                                 std::uint32_t changes);

class SceneSessions {
 public:
  /// The scene must outlive this. A session that sends nothing for `silence_timeout` ends. With a
  /// `line` a session gets at most the rate that the line has room for.
  SceneSessions(const Scene& scene, Nanoseconds silence_timeout, std::size_t max_sessions,
                const NetworkProfile* line = nullptr, const SessionLimits& limits = {});
  ~SceneSessions();

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
  std::string seat_name(std::size_t seat) const;
  /// The newest target of the robot on a seat, and its receiver; empty: none is due. Call it after
  /// receive(), once for all datagrams that came together, because older targets are useless. Never
  /// allocates. Precondition: seat < seats().
  Bytes forward(std::size_t seat, Nanoseconds now, Peer& to, DatagramBuffer& out) noexcept;
  /// The state between the robot on a seat and the hand that leads it. Precondition: as above.
  LinkState link_state(std::size_t seat) const noexcept { return seats_[seat].link.state(); }

  /// Charges the time of all datagrams since the last call (FairShare). Never allocates.
  void spent(Nanoseconds time, Nanoseconds now) noexcept {
    share_.charge(time);
    share_.balance(now);
  }
  /// Charges time that no session caused, for example of a tick.
  void spent_otherwise(Nanoseconds time) noexcept { share_.charge_other(time); }
  const FairShare& share() const { return share_; }
  /// The number of datagrams that were dropped because their session was above its share.
  std::uint64_t shed() const { return counters_.shed; }

  /// Steps the moving objects up to `now`, with the push of each session. Every received datagram
  /// does the same. Time stops while there is no session. After a stall at most kMostTicks ticks
  /// are made up for, and the rest of the time is dropped. If that happens again and again, because
  /// a tick takes longer than it lasts, the limit is halved each time, so that hands wait for one
  /// tick and not for twenty. It allocates only if the contacts need more room than ever before
  /// (docs/moving.md).
  void tick(Nanoseconds now) noexcept;
  /// The time of the next step. Empty: no object moves, or there is no session.
  std::optional<Nanoseconds> next_tick() const;
  static constexpr int kMostTicks = 20;
  /// Steps of the world that were dropped because the server was too late.
  std::uint64_t ticks_dropped() const { return counters_.ticks_dropped; }
  /// The world of the moving objects; null: nothing moves.
  const World* world() const { return world_.get(); }

  /// A goodbye and its receiver.
  struct GoodbyeDatagram {
    Peer to;
    std::vector<std::uint8_t> datagram;
  };
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
  ChangeOutcome change(const LiveChange& change, Nanoseconds now);
  /// The answers of clients to changes since the last call, one log line each. Allocates if there
  /// are any.
  std::vector<std::string> answers();
  bool has_answers() const noexcept { return has_answers_; }
  /// The payload of a session's replies is at most so long from now on [bytes], because its path
  /// takes no longer ones: they carry less of the model or the view. After a minute longer ones are
  /// tried again. A session that does not exist is none of its business. Never allocates.
  void limit_replies(std::uint64_t id, std::size_t payload, Nanoseconds now) noexcept;
  /// Whether a session's replies have less room than that already, or there is no such session.
  bool is_limited(std::uint64_t id, std::size_t payload) noexcept;
  /// The sessions whose path was found to be short since the last call, one log line each.
  /// Allocates if there are any.
  std::vector<std::string> short_paths();
  bool has_short_paths() const noexcept { return has_short_paths_; }
  /// [m/s^2] on moving objects; empty: nothing moves.
  std::optional<Vec3> gravity() const;

  /// Ends the sessions that were silent for too long, that flooded, that broke the simulation again
  /// and again, or under whose id too many foreign datagrams came.
  std::vector<GoodbyeDatagram> expire(Nanoseconds now);
  /// Ends one session, if it exists.
  std::vector<GoodbyeDatagram> evict(std::uint64_t id);
  /// Ends all sessions, because the server ends or failed in this scene. If there is no memory for
  /// a goodbye, a session gets none.
  std::vector<GoodbyeDatagram> shut_down() noexcept {
    return end_all(GoodbyeReason::shutting_down);
  }
  std::vector<GoodbyeDatagram> fail() noexcept { return end_all(GoodbyeReason::failed); }

  /// Sessions that have ended since forget_ended().
  const std::vector<EndedSession>& ended() const { return ended_; }
  void forget_ended() noexcept { ended_.clear(); }

  /// The places of all hands and moving objects. May allocate; throws only std::bad_alloc.
  void draw(Picture& picture, Nanoseconds now) const;
  /// A description of each hand. Allocates.
  std::vector<HandDescription> describe() const;

  /// All sessions with greater numbers, at most control::kMaxDescriptions. Allocates.
  control::SessionDescriptions describe_after(std::uint32_t number, Nanoseconds now) const;

  /// From now on, all inputs that decide a reply go into the log, which must outlive this; null:
  /// none. A log can be replayed only if it began before the first session.
  void log_to(EventLog* log) noexcept { log_.log_to(log); }
  /// Logs the places of all moving objects, for a replay to compare. Never allocates.
  void check(Nanoseconds now) noexcept { log_.check(world_.get(), now); }

  // For a replay (server/recording/scene_replay.hpp).
  /// Does the work of receive() for the payload of an accepted datagram. Returns the payload of the
  /// answer; empty if there is no answer or no such session.
  Bytes replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept;
  /// Ends a session, if it exists, without a goodbye.
  void replay_end(std::uint64_t id, SessionEnd how) noexcept;

  /// Counts the scenes, from 1: one more with each enter().
  std::uint32_t scene_version() const noexcept { return version_; }
  /// Live changes of materials and gravity so far.
  std::uint32_t live_changes() const noexcept { return live_changes_; }

  std::size_t size() const { return slots_.size(); }
  /// Running sessions included.
  SceneCounters counters() const;
  const Session* find(std::uint64_t id);

 private:
  struct Change;
  /// A seat of the scene for a robot.
  struct Seat {
    TeleopLink link;
    SessionSlot* robot = nullptr;      // who sits there
    Workspace own = {};                // the robot's own
    std::optional<WorldArm> arm = {};  // the robot is of the world, and sits there always
  };
  void hear_answer(SessionSlot& slot) noexcept;
  std::unique_ptr<World> world_of(const Scene& scene) const;
  void take_over(const Scene& scene, std::unique_ptr<World> world,
                 std::vector<Seat> seats) noexcept;
  std::vector<Seat> seats_of(const Scene& scene, World* world) const;
  bool has_same_seats(const Scene& scene) const noexcept;
  std::vector<GoodbyeDatagram> end_all(GoodbyeReason reason) noexcept;
  control::Message join(control::JoinRequest request, std::uint64_t id, const SessionKeys& keys,
                        Nanoseconds now);
  control::Counters named_counters() const;
  control::Message take_surfaces(const control::TakeSurfaces& request, Nanoseconds now);
  SessionParameters granted(const SessionParameters& asked) const;
  Bytes receive_samples(SessionSlot& slot, Bytes payload, const Origin& origin,
                        DatagramBuffer& out) noexcept;
  Bytes answer_samples(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept;
  Bytes show(SessionSlot& slot, const Reply& reply, Nanoseconds now) noexcept;
  Bytes fitted(SessionSlot& slot, Reply& reply, Nanoseconds now) noexcept;
  std::size_t room_of(SessionSlot& slot, std::size_t whole, Nanoseconds now) noexcept;
  void limit_replies(SessionSlot& slot, std::size_t payload, Nanoseconds now) noexcept;
  std::optional<control::Refused> refuse_robot(const control::JoinRequest& request) const;
  const RemoteSeat* seat_named(const std::string& name) const noexcept;
  void receive_state(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept;
  Remote lead(SessionSlot& slot, Nanoseconds now) noexcept;
  bool leads_arm(const SessionSlot& slot) const noexcept;
  std::optional<SeenRobot> seen_robot(std::size_t seat, Nanoseconds now) const noexcept;
  std::optional<SeenRobot> next_robot(SessionSlot& observer, Nanoseconds now) const noexcept;
  void add_figures(SceneView& view, Nanoseconds now) const noexcept;
  PictureHand picture_of(const SessionSlot& slot, Nanoseconds now) const noexcept;
  struct Ending;
  std::optional<Ending> ending(const SessionSlot& slot, Nanoseconds now) const noexcept;
  void end(SessionSlot& slot, SessionEnd how) noexcept;
  GoodbyeDatagram take_away(SessionSlot& slot, SessionEnd how);
  void blame(Nanoseconds now) noexcept;
  Bytes drop(DropReason reason) noexcept;
  Bytes miss(const Header& header) noexcept;
  GoodbyeDatagram goodbye(SessionSlot& slot, GoodbyeReason reason);

  const Scene* scene_;
  std::uint32_t version_ = 1, live_changes_ = 0;
  Nanoseconds silence_timeout_;
  std::size_t max_sessions_;
  const NetworkProfile* line_;
  SessionLimits limits_;
  std::unique_ptr<World> world_;
  Nanoseconds tick_{0}, last_tick_{0};  // of the world: length, time
  int most_ticks_ = kMostTicks;  // largest number of ticks that one call makes up for at present
  SessionSlots slots_;
  std::vector<ActingHand> hands_;  // of those, without the observers'
  IdMap<SessionSlot*> by_id_;
  std::vector<Seat> seats_;  // for robots
  FairShare share_;
  std::array<std::uint64_t, 64> gone_{};  // the sessions that ended last
  std::size_t next_gone_ = 0;
  std::vector<EndedSession> ended_;  // no more than there were sessions between two joins
  Encoder encoder_;
  DatagramBuffer opened_;  // the present datagram
  SampleBatch batch_;      // its samples
  SceneView view_;         // for the observer that sent it
  RobotState robot_state_;
  SceneCounters counters_;
  bool has_answers_ = false;  // clients have answered to changes
  bool has_short_paths_ = false;
  SceneLog log_;
};

}  // namespace feltwire
