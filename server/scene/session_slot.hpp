#pragma once

#include <string>

#include "server/scene/sample_rate.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

/// Where and when a datagram came.
struct SceneSessions::Origin {
  const Peer& from;
  bool newest;  // of its session
  Nanoseconds now;
};

/// The body of a message's frame, for the event log.
inline std::vector<std::uint8_t> body(const control::Message& message) {
  std::vector<std::uint8_t> frame = control::encode(message);
  frame.erase(frame.begin(), frame.begin() + control::kFrameLengthSize);
  return frame;
}

/// A change that a session's client was asked for.
struct SceneSessions::AskedChange {
  ClientChange change;
  SessionParameters parameters;  // with its law, for when the client takes it
  std::string what;              // for people: from what to what
  ChangeAnswer answer = ChangeAnswer::waiting;
  bool told = true;  // the log has that answer
  /// A law was asked for before, and what the client made of that was not heard.
  bool unheard_law = false;
  /// That one was followed by a refusal: the client is asked for the law of its session.
  bool returns = false;
};

/// A session and what belongs to its transport.
struct SceneSessions::SessionSlot {
  std::uint64_t id;
  Session session;
  Nanoseconds last_heard;
  Opener opener;  // of what comes
  Sealer sealer;  // of what goes
  SampleRate rate;
  Peer peer;                   // of the newest datagram with a newer sample
  ObserverView observer_view;  // of an observer
  std::string tool;            // that was asked for; empty: the scene's first
  Role role = Role::observer;
  // Resets that its hand may still be blamed for.
  TokenBucket resets{SessionLimits::kResets / SessionLimits::kResetTime, SessionLimits::kResets};
  std::uint32_t number = 0;  // from 1 in the order they joined, as ActingHand has it
  std::uint32_t share = 0;   // its number in SceneSessions::share_
  bool figures = false;      // of an observer: it is shown the figures of hands
  bool disturbing = false;   // it had none left: it pushes nothing any more, and ends
  ChangesTaken takes = {};   // at the client
  std::optional<AskedChange> asked = {};

  bool waits_for_client() const { return asked && asked->answer == ChangeAnswer::waiting; }
};

}  // namespace feltwire
