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

/// Of a message's frame, for the event log.
inline std::vector<std::uint8_t> body(const control::Message& message) {
  std::vector<std::uint8_t> frame = control::encode(message);
  frame.erase(frame.begin(), frame.begin() + control::kFrameLengthSize);
  return frame;
}

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
  // Resets that its hand may still be blamed for.
  TokenBucket resets{SessionLimits::kResets / SessionLimits::kResetTime, SessionLimits::kResets};
  std::uint32_t number = 0;  // from 1 in the order they joined, as ActingHand has it
  std::uint32_t share = 0;   // its number in SceneSessions::share_
  bool disturbing = false;   // it had none left: it pushes nothing any more, and ends
};

}  // namespace feltwire
