#pragma once
// All sessions of one scene: from a datagram's bytes to the answer's. No socket, no clock.

#include <sys/socket.h>

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
#include "server/scene/event_log.hpp"
#include "server/scene/fair_share.hpp"
#include "server/scene/id_map.hpp"
#include "server/scene/live_change.hpp"
#include "server/scene/observer_view.hpp"
#include "server/scene/remote_link.hpp"
#include "server/scene/session.hpp"
#include "server/scene/session_end.hpp"

namespace feltwire {

/// Where a datagram came from and its answer goes to.
struct Peer {
  sockaddr_storage address{};
  socklen_t length = 0;  // [bytes] 0: not known yet
};

/// The limits of a session. Beyond them it is slowed or ended.
struct SessionLimits {
  static constexpr double kSampleRate = 1.5;
  double sample_rate = kSampleRate;  // times its servo rate, > 1 (server/scene/sample_rate.hpp)
  /// Datagrams under its id that were not sealed with its keys; never more than the cipher stands
  /// (forgery_limit).
  std::uint64_t forgeries = ~std::uint64_t{0};
  /// Resets of what moves that its hand is blamed for: so many at once, and again within the time
  /// [s]; with one more the session ends.
  static constexpr int kResets = 5;
  static constexpr double kResetTime = 10.0;
};

struct SceneCounters {
  std::uint64_t sessions_served = 0;
  // How they ended: by goodbye or request, by silence, by flooding, by too many forgeries, by an
  // admin or because their token is good no more or their tool is in the scene no more.
  std::uint64_t left = 0, silent = 0, flooded = 0, forged = 0, evicted = 0;
  std::uint64_t disturbing = 0;     // ended as well, for they broke what moves again and again
  std::uint64_t failed = 0;         // ended as well, for the server failed in this scene
  std::uint64_t datagrams = 0;      // received
  std::uint64_t late_goodbyes = 0;  // of these, under the number of a session that had just ended
  SessionCounters samples;          // over all sessions
  WorldCounters world;              // zero where nothing moves
  std::uint64_t ticks_dropped = 0;  // of the world, when the thread could not keep up
  std::uint64_t shed =
      0;  // of the drops by rate, those of sessions above their share of the thread
  std::array<std::uint64_t, kDropReasons> drops{};
  TimeCounts world_late;  // of each waking for the world: after its time
};

/// A session that is not there, or not any more.
control::Refused unknown_session(std::uint64_t id);

class SceneSessions {
 public:
  /// The scene must outlive this. A session that sends nothing for `silence_timeout` ends. With a
  /// `line` a session is granted no more than it has room for.
  SceneSessions(const Scene& scene, Nanoseconds silence_timeout, std::size_t max_sessions,
                const NetworkProfile* line = nullptr, const SessionLimits& limits = {});
  ~SceneSessions();

  /// Join, leave, set parameters, list sessions and counters; anything else is refused as
  /// malformed. `id` and `keys` are the new session's for a join, else unused. Numbers that are not
  /// possible come back as Refused.
  control::Message answer(const control::Message& request, std::uint64_t id,
                          const SessionKeys& keys, Nanoseconds now);

  /// One datagram, all checks of PROTOCOL.md in their order. The answer is sealed into `out`; empty
  /// when there is none. Never allocates.
  Bytes receive(Bytes datagram, const Peer& from, Nanoseconds now, DatagramBuffer& out) noexcept;

  /// The newest target of the scene's robot, and where it goes; empty: none is due. Call it after
  /// receive(), once for all that came together: older targets are of no use. Never allocates.
  Bytes forward(Nanoseconds now, Peer& to, DatagramBuffer& out) noexcept;
  /// The state between the scene's leading hand and its robot; `disabled` without a robot's seat.
  LinkState link_state() const noexcept { return link_ ? link_->state() : LinkState::disabled; }

  /// Tells how long all datagrams since the last call took together (FairShare). Never allocates.
  void spent(Nanoseconds time, Nanoseconds now) noexcept {
    share_.charge(time);
    share_.balance(now);
  }
  /// Something that no session caused, as a tick, took so long.
  void spent_otherwise(Nanoseconds time) noexcept { share_.charge_other(time); }
  const FairShare& share() const { return share_; }
  /// The number of datagrams that were dropped because their session was above its share.
  std::uint64_t shed() const { return counters_.shed; }

  /// Steps the moving objects up to `now`, with the push of each session. Every datagram that is
  /// received does the same. Time stands still while there is no session. After a stall at most
  /// kMostTicks ticks are made up for, and the rest of the time is dropped. Where that happens
  /// again and again, because a tick takes longer than it lasts, the limit is halved each time, so
  /// that hands wait for one tick and not for twenty. Allocates only where the contacts need more
  /// room than ever before (docs/moving.md).
  void tick(Nanoseconds now) noexcept;
  /// The time of the next step. Nothing: no object moves, or there is no session.
  std::optional<Nanoseconds> next_tick() const;
  static constexpr int kMostTicks = 20;
  /// Steps of the world that were left out because the server was too late.
  std::uint64_t ticks_dropped() const { return counters_.ticks_dropped; }
  /// The world of the moving objects; null: nothing moves.
  const World* world() const { return world_.get(); }

  /// A goodbye and whom it is for.
  struct GoodbyeDatagram {
    Peer to;
    std::vector<std::uint8_t> datagram;
  };
  /// All sessions go on in another scene, where nothing has moved yet, with the tools that they
  /// asked for; those end whose tool it does not have. It must outlive this; the one before is not
  /// looked at any more. Allocates; throws and changes nothing where there is no memory for it.
  std::vector<GoodbyeDatagram> enter(const Scene& scene, Nanoseconds now);

  /// Makes a change from the next sample on, or refuses it; a refused one changes nothing. Every
  /// live change of a scene and of its sessions comes through here, on the scene's thread and
  /// between two datagrams, and goes into the log. The scene that the outcome may have must outlive
  /// this. Allocates; throws std::bad_alloc and changes nothing where there is no memory for it.
  ChangeOutcome change(const LiveChange& change, Nanoseconds now);
  /// What clients have answered to changes since the last call, a line each for the log. Allocates
  /// where there is something to say.
  std::vector<std::string> answers();
  bool has_answers() const noexcept { return has_answers_; }
  /// [m/s^2] on what moves; nothing: nothing moves.
  std::optional<Vec3> gravity() const;

  /// Ends the sessions that have been silent for too long, that flooded, that broke what moves
  /// again and again, or under whose id too much came that was not theirs.
  std::vector<GoodbyeDatagram> expire(Nanoseconds now);
  /// Ends one session, if it is there.
  std::vector<GoodbyeDatagram> evict(std::uint64_t id);
  /// Ends all sessions: the server does, or it failed in this scene. No goodbye goes to a session
  /// where there is no memory for one.
  std::vector<GoodbyeDatagram> shut_down() noexcept {
    return end_all(GoodbyeReason::shutting_down);
  }
  std::vector<GoodbyeDatagram> fail() noexcept { return end_all(GoodbyeReason::failed); }

  /// Sessions that have ended since forget_ended().
  const std::vector<EndedSession>& ended() const { return ended_; }
  void forget_ended() noexcept { ended_.clear(); }

  /// Where all hands and moving objects are. May allocate; throws nothing else than
  /// std::bad_alloc.
  void draw(Picture& picture, Nanoseconds now) const;
  /// A description of each hand. Allocates.
  std::vector<HandDescription> describe() const;

  /// All sessions with greater numbers, at most control::kMaxDescriptions. Allocates.
  control::SessionDescriptions describe_after(std::uint32_t number) const;

  /// From now on, all that decides a reply goes into the log, which must outlive this; null: no
  /// more. A log can be replayed only where it has been there since before the first session.
  void log_to(EventLog* log) noexcept { log_ = log; }
  /// Notes where everything is that moves, for a replay to compare. Never allocates.
  void check(Nanoseconds now) noexcept;

  // For a replay (server/recording/replay.hpp).
  /// Does what receive() does with the payload of an accepted datagram. Returns the payload of the
  /// answer; empty where there is no answer or no such session.
  Bytes replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept;
  /// Ends a session, if it is there, without a goodbye.
  void replay_end(std::uint64_t id, SessionEnd how) noexcept;

  std::size_t size() const { return slots_.size(); }
  /// Running sessions included.
  SceneCounters counters() const;
  const Session* find(std::uint64_t id);

 private:
  struct SessionSlot;
  struct Origin;
  struct Change;
  struct AskedChange;
  void hear_answer(SessionSlot& slot) noexcept;
  std::unique_ptr<World> world_of(const Scene& scene) const;
  void take_over(const Scene& scene, std::unique_ptr<World> world);
  std::vector<GoodbyeDatagram> end_all(GoodbyeReason reason) noexcept;
  control::Message join(control::JoinRequest request, std::uint64_t id, const SessionKeys& keys,
                        Nanoseconds now);
  control::Counters named_counters() const;
  SessionParameters granted(const SessionParameters& asked) const;
  Bytes receive_samples(SessionSlot& slot, Bytes payload, const Origin& origin,
                        DatagramBuffer& out) noexcept;
  Bytes answer_samples(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept;
  Bytes show(SessionSlot& slot, const Reply& reply, Nanoseconds now) noexcept;
  std::optional<control::Refused> refuse_robot(const control::JoinRequest& request) const;
  void receive_state(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept;
  void add_figures(SceneView& view, Nanoseconds now) const noexcept;
  PictureHand picture_of(const SessionSlot& slot, Nanoseconds now) const noexcept;
  void log(SceneEvent event) noexcept {
    if (log_ == nullptr) return;
    logged_at_ = event.time;
    log_->put(event);
  }
  struct Ending;
  std::optional<Ending> ending(const SessionSlot& slot, Nanoseconds now) const noexcept;
  void end(SessionSlot& slot, SessionEnd how) noexcept;
  GoodbyeDatagram take_away(SessionSlot& slot, SessionEnd how);
  void blame(Nanoseconds now) noexcept;
  Bytes drop(DropReason reason) noexcept;
  Bytes miss(const Header& header) noexcept;
  GoodbyeDatagram goodbye(SessionSlot& slot, GoodbyeReason reason);

  const Scene* scene_;
  Nanoseconds silence_timeout_;
  std::size_t max_sessions_;
  const NetworkProfile* line_;
  SessionLimits limits_;
  std::unique_ptr<World> world_;
  Nanoseconds tick_{0}, last_tick_{0};               // of the world: length, time
  int most_ticks_ = kMostTicks;                      // that one call makes up for at present
  std::vector<std::unique_ptr<SessionSlot>> slots_;  // in the order they joined
  std::vector<ActingHand> hands_;                    // of those, without the observers'
  IdMap<SessionSlot*> by_id_;
  std::optional<RemoteLink> link_;  // where the scene has a robot's seat
  SessionSlot* robot_ = nullptr;    // who sits there
  Workspace robot_workspace_;       // of its own
  FairShare share_;
  std::array<std::uint64_t, 64> gone_{};  // the sessions that ended last
  std::size_t next_gone_ = 0;
  std::vector<EndedSession> ended_;  // no more than there were sessions between two joins
  Encoder encoder_;
  DatagramBuffer opened_;  // the datagram at hand
  SampleBatch batch_;      // what it brings
  SceneView view_;         // for the observer that sent it
  RobotState robot_state_;
  SceneCounters counters_;
  bool has_answers_ = false;  // of clients, to changes
  EventLog* log_ = nullptr;
  Nanoseconds logged_at_{0};  // the newest event's time
};

}  // namespace feltwire
