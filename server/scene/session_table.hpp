#pragma once
// The sessions of a scene: who joins, who ends and why, and their descriptions.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/session/profiles.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/picture.hpp"
#include "server/scene/fair_share.hpp"
#include "server/scene/observer_view.hpp"
#include "server/scene/robot_seats.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/served_scene.hpp"
#include "server/scene/session_end.hpp"
#include "server/scene/session_ids.hpp"
#include "server/scene/session_limits.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/world_clock.hpp"

namespace feltwire {

/// A goodbye and its receiver.
struct GoodbyeDatagram {
  Peer to;
  std::vector<std::uint8_t> datagram;
};

struct SessionTableCounters {
  std::uint64_t sessions_served = 0;
  // Ended sessions by cause: goodbye or request, silence, flooding, too many forgeries, an admin or
  // an invalid token or a missing tool.
  std::uint64_t left = 0, silent = 0, flooded = 0, forged = 0, evicted = 0;
  std::uint64_t disturbing = 0;  // also ended, because they broke the simulation again and again
  std::uint64_t failed = 0;      // also ended, because the server failed in this scene
  SessionCounters samples;       // over all sessions
  // Sums over all clients that report them, by the classes of HandTimes.
  HandTimesHeard::Totals client_wakeups{}, client_round_trips{};
};

/// The limits of a scene's sessions.
struct TableOptions {
  Nanoseconds silence_timeout{};  // a session that sends nothing for so long ends
  std::size_t max_sessions = 0;
  /// A session gets at most the rate that this line has room for; null: no limit. It must outlive
  /// the table.
  const NetworkProfile* line = nullptr;
  SessionLimits session = {};
};

/// A session that does not exist, or no longer.
control::Refused unknown_session(std::uint64_t id);

class SessionTable {
 public:
  /// The other stages must outlive this.
  SessionTable(const TableOptions& options, const ServedScene& served, WorldClock& clock,
               RobotSeats& seats, FairShare& share, SceneLog& log);

  bool empty() const noexcept { return slots_.empty(); }
  std::size_t size() const noexcept { return slots_.size(); }
  const SessionSlots& slots() const noexcept { return slots_; }
  /// The sessions that feel the scene, in the same order.
  std::span<const ActingHand> hands() const noexcept { return hands_; }
  SessionIds& ids() noexcept { return ids_; }
  /// Null if there is none.
  SessionSlot* find(std::uint64_t id) noexcept { return ids_.find(id); }

  /// JoinAccepted, or Refused, which changes nothing. Allocates.
  control::Message join(control::JoinRequest request, std::uint64_t id, const SessionKeys& keys,
                        Nanoseconds now);
  /// The session ends as its client wishes: by a goodbye, or `asked`.
  void leave(SessionSlot& slot, SessionEnd how) noexcept;
  /// The session ends without a goodbye.
  void end(SessionSlot& slot, SessionEnd how) noexcept;

  /// Ends the sessions that were silent for too long, that flooded, that broke the simulation again
  /// and again, or under whose id too many foreign datagrams came.
  std::vector<GoodbyeDatagram> expire(Nanoseconds now);
  /// Ends one session, if it exists.
  std::vector<GoodbyeDatagram> evict(std::uint64_t id);
  /// Ends all sessions, because the server `failed` in this scene or is `shutting_down`. If there
  /// is no memory for a goodbye, a session gets none.
  std::vector<GoodbyeDatagram> end_all(GoodbyeReason reason) noexcept;

  /// The moves of all sessions to another scene.
  struct Moves {
    std::vector<Session::Place> places;  // of the slots; without a view: that session ends
    std::vector<GoodbyeDatagram> goodbyes;
    bool same_seats = false;
  };
  /// `world`: of the scene; null: nothing moves. Sessions without a tool there end, and if it has
  /// other seats, robots and the hands that lead them. Allocates, and changes nothing.
  Moves moves_to(const Scene& scene, World* world, bool same_seats);
  void carry_out(Moves& moves) noexcept;

  /// Sessions that have ended since forget_ended().
  const std::vector<EndedSession>& ended() const noexcept { return ended_; }
  void forget_ended() noexcept { ended_.clear(); }

  /// A description of each hand, for viewers. Allocates.
  std::vector<HandDescription> describe() const;
  /// All sessions with greater numbers, at most control::kMaxDescriptions. Allocates.
  control::SessionDescriptions describe_after(std::uint32_t number, Nanoseconds now) const;
  /// Running sessions included.
  SessionTableCounters counters() const;

 private:
  GoodbyeDatagram goodbye(SessionSlot& slot, GoodbyeReason reason);
  SessionParameters granted(const SessionParameters& asked) const;

  TableOptions options_;
  const ServedScene& served_;
  WorldClock& clock_;
  RobotSeats& seats_;
  FairShare& share_;
  SceneLog& log_;
  SessionSlots slots_;
  std::vector<ActingHand> hands_;  // of the slots, without the observers'
  SessionIds ids_;
  std::vector<EndedSession> ended_;  // no more than there were sessions between two joins
  Encoder encoder_;
  SessionTableCounters counters_;  // without the samples of the running sessions
};

}  // namespace feltwire
