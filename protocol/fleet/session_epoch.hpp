#pragma once

#include <optional>

#include "protocol/fleet/epoch.hpp"

namespace feltwire {

/// The knowledge of a client about the owner of its scene. It never has a session below `highest`.
struct SessionEpoch {
  Epoch highest;                 // ever seen, in an answer, a redirect or a listing
  std::optional<Epoch> session;  // at which its session was accepted; empty: it has none

  friend bool operator==(const SessionEpoch&, const SessionEpoch&) = default;
};

/// A host has accepted a join at this epoch. Returns whether the client takes the session; if not,
/// it closes the new session at once.
constexpr bool take_session(SessionEpoch& known, const Epoch& offered) noexcept {
  if (!admit(known.highest, offered)) return false;
  known.session = offered;
  return true;
}

/// The client learns that the scene has an owner at this epoch. Returns whether its session must
/// end, because it is of an owner before that.
constexpr bool hear_epoch(SessionEpoch& known, const Epoch& heard) noexcept {
  if (!admit(known.highest, heard) || !known.session || *known.session == heard) return false;
  known.session.reset();
  return true;
}

}  // namespace feltwire
