#pragma once
// Changes of a running scene, as plain values: the same change in the same state has the same
// result, bit for bit.

#include <cstdint>
#include <variant>

#include "core/base/types.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/material_change.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// Another gravity on moving bodies.
struct GravityChange {
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
};
/// Other parameters of one session, of those that a running session can change (grant.hpp). If the
/// client bounds, its law changes when the client reports that it has taken the change.
struct ParameterChange {
  std::uint64_t session = 0;
  SessionParameters parameters;
};
/// Another link for a session's client to emulate, from the time when the client takes it.
struct LinkChange {
  std::uint64_t session = 0;
  LinkQuality link;
};
/// Another share of a hand in the lead of its scene's robot (lead_share.hpp).
struct LeadChange {
  std::uint64_t session = 0;
  double share = 0.0;
};
using LiveChange =
    std::variant<MaterialChange, GravityChange, ParameterChange, LinkChange, LeadChange>;

}  // namespace feltwire
