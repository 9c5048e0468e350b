#pragma once
// All sessions of one scene: from a datagram's bytes to the answer's. No socket, no clock.

#include <sys/socket.h>

#include <array>
#include <memory>
#include <vector>

#include "protocol/codec.hpp"
#include "protocol/control.hpp"
#include "protocol/profiles.hpp"
#include "protocol/sequence.hpp"
#include "server/id_map.hpp"
#include "server/session.hpp"

namespace feltwire {

/// Where a datagram came from and its answer goes to.
struct Peer {
  sockaddr_storage address{};
  socklen_t length = 0;  // [bytes] 0: not known yet
};

struct SceneCounters {
  std::uint64_t sessions_served = 0;
  std::uint64_t left = 0, silent = 0;  // how they ended: by goodbye or request, by silence
  std::uint64_t datagrams = 0;         // received
  std::uint64_t violations = 0;        // of the energy bound at the real ports
  SessionCounters samples;             // over all sessions
  std::array<std::uint64_t, kDropReasons> drops{};
};

class SceneSessions {
 public:
  /// The scene must outlive this. A session that sends nothing for `silence_timeout` ends. With a
  /// `line` a session is granted no more than it has room for.
  SceneSessions(const Scene& scene, Nanoseconds silence_timeout, std::size_t max_sessions,
                const NetworkProfile* line = nullptr);
  ~SceneSessions();

  /// Join, leave, set parameters; anything else is refused as malformed. `id` is the new session's
  /// for a join, else unused. Numbers that are not possible come back as Refused.
  control::Message answer(const control::Message& request, std::uint64_t id, Nanoseconds now);

  /// One datagram, all checks of PROTOCOL.md in their order. The answer's bytes, empty when there
  /// is none, live until the next call. Never allocates.
  Bytes receive(Bytes datagram, const Peer& from, Nanoseconds now) noexcept;

  /// A goodbye and whom it is for.
  struct Farewell {
    Peer to;
    std::vector<std::uint8_t> datagram;
  };
  /// Ends the sessions that have been silent for too long.
  std::vector<Farewell> expire(Nanoseconds now);
  /// Ends all sessions.
  std::vector<Farewell> shut_down();

  std::size_t size() const { return seats_.size(); }
  /// Running sessions included.
  SceneCounters counters() const;
  const Session* find(std::uint64_t id);

 private:
  struct Seat;
  control::Message join(control::JoinRequest request, std::uint64_t id, Nanoseconds now);
  SessionParameters granted(const SessionParameters& asked) const;
  Bytes receive_samples(Seat& seat, Bytes payload, const Peer& from, Nanoseconds now) noexcept;
  void end(Seat& seat) noexcept;
  Bytes drop(DropReason reason) noexcept;
  Farewell farewell(Seat& seat, GoodbyeReason reason);

  const Scene& scene_;
  Nanoseconds silence_timeout_;
  std::size_t max_sessions_;
  const NetworkProfile* line_;
  std::vector<std::unique_ptr<Seat>> seats_;  // in the order they joined
  IdMap<Seat*> by_id_;
  Encoder encoder_;
  SampleBatch batch_;  // of the datagram at hand
  SceneCounters counters_;
};

}  // namespace feltwire
