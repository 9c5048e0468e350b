#pragma once
// A session with the data that the stages of its scene keep of it.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/token_bucket.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"
#include "protocol/crypto/session_keys.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/role.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/seal.hpp"
#include "server/scene/observer_view.hpp"
#include "server/scene/peer_address.hpp"
#include "server/scene/sample_rate.hpp"
#include "server/scene/session.hpp"
#include "server/scene/session_limits.hpp"

namespace feltwire {

/// The sender and the time of a datagram.
struct Origin {
  const Peer& from;
  bool newest;  // of its session
  Nanoseconds now;
};

/// A change that was requested of a session's client.
struct AskedChange {
  ClientChange change;
  SessionParameters parameters;  // with its law, for the time when the client takes it
  std::string what;              // for people: the old and the new value
  ChangeAnswer answer = ChangeAnswer::waiting;
  bool told = true;  // the answer is in the log
  /// A law was requested before, and the client has not answered.
  bool unheard_law = false;
  /// That request was followed by a refusal: the client is asked for the law of its session.
  bool returns = false;
};

/// The replies that the path to a client takes.
struct PathRoom {
  std::size_t room = kMaxPayload;  // [bytes] of a reply's payload, as the path was found to take
  Nanoseconds until{0};            // then longer ones are tried again
  bool was_short = false;          // the room was less once
  bool told = false;               // the log says so
};

/// How often a session's client sends (server/scene/pace.hpp).
struct SlotPace {
  std::uint8_t intervals = 1;  // packet intervals between two datagrams, as the client was asked
  Nanoseconds since{0};
};

/// An observer's progress through the scene.
struct ObserverProgress {
  ObserverView view;
  bool figures = false;   // it gets the figures of hands
  std::uint8_t seat = 0;  // of the robot in its last view
};

/// The resets of a simulation for which a hand is blamed.
struct ResetBlame {
  // Resets of the world for which it may still be blamed.
  TokenBucket resets{SessionLimits::kResets / SessionLimits::kResetTime, SessionLimits::kResets};
  bool disturbing = false;  // it had no reset left: it pushes nothing any more, and ends
};

/// A session with the data of its transport.
struct SessionSlot {
  /// Joins at `now`. Throws as Session does, and std::invalid_argument if the cipher suite is not
  /// supported.
  SessionSlot(std::uint64_t session_id, const control::JoinRequest& request, const ToolView& view,
              World* world, const SessionKeys& keys, const SessionLimits& limits, Nanoseconds now)
      : id(session_id),
        session(request, view, world),
        opener(keys.suite, keys.up, 0, limits.forgeries),
        sealer(keys.suite, keys.down),
        rate(request.parameters.servo_period, limits.sample_rate),
        tool(request.tool),
        role(request.role),
        last_heard(now),
        joined(now),
        takes(session.observes() ? ChangesTaken{} : request.takes),
        lead_share(request.lead_share) {
    observer.figures = request.figures && session.observes();
  }

  std::uint64_t id;
  Session session;
  Opener opener;  // of received datagrams
  Sealer sealer;  // of sent datagrams
  SampleRate rate;
  std::string tool;  // the requested one; empty: the scene's first
  Role role;
  std::uint32_t number = 0;  // from 1 in the order of joining, as in ActingHand
  std::uint32_t share = 0;   // its number in FairShare
  Nanoseconds last_heard, joined;
  Peer peer;      // of the newest datagram with a newer sample
  PathRoom path;  // from here to the peer
  SlotPace pace;
  ResetBlame blame;
  ChangesTaken takes;  // changes that its client takes
  std::optional<AskedChange> asked = {};
  double lead_share;      // for TeleopLink::lead()
  std::uint8_t seat = 0;  // a robot's, or that of the robot that the hand leads
  bool leads = false;     // its samples have a lead
  ObserverProgress observer;

  ClientChangeState changes() const {
    if (!asked) return {.takes = takes};
    return {.takes = takes, .asked = asked->what, .answer = asked->answer};
  }
  bool waits_for_client() const { return asked && asked->answer == ChangeAnswer::waiting; }
};

/// The sessions of a scene, in the order they joined.
using SessionSlots = std::vector<std::unique_ptr<SessionSlot>>;

}  // namespace feltwire
