#pragma once
// The session parameters that a server may change from the client's request. A client checks every
// grant with these rules, so that no server takes the bound off a hand. A server checks every
// request to change a running session with them.

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

inline constexpr double kShortestUsualHold = 0.1;   // [s] a grant shortens hold_time no further
inline constexpr double kLongestGrantedHold = 0.8;  // [s] of a profile: the longest that a server
                                                    // grants by itself

/// The grants beyond the request that the owner of a client allows.
struct GrantLimits {
  double hold_time = 0.0;  // [s] the longest hold_time; 0, or less than asked for: as asked for
};

/// The side that uses a parameter while a session runs, and so must know of a change.
enum class ActedOnBy : std::uint8_t {
  client,  // the client uses it, too: it cannot be changed
  bound,   // the bounding side: it can be changed if that is the server alone. The law of a client
           // (mode, projection, storage) changes in another way: client_change.hpp
  server   // only the server: it can be changed
};

/// The rule of one field. `may_grant` says whether the server may grant another value than the
/// requested one; null: it may not.
template <class Value>
struct ParameterRule {
  const char* field;
  Value SessionParameters::*value;
  ActedOnBy acted_on_by;
  bool (*may_grant)(const SessionParameters& asked, const SessionParameters& granted,
                    const GrantLimits& limits);
};

namespace grant {

/// The amount of traffic, within the ranges of validate().
inline bool traffic(const SessionParameters&, const SessionParameters&, const GrantLimits&) {
  return true;
}
/// The bound may move to the client, and never away from it.
inline bool to_client(const SessionParameters& asked, const SessionParameters& granted,
                      const GrantLimits&) {
  return asked.side == BoundingSide::server && granted.side == BoundingSide::client;
}
/// No shorter than kShortestUsualHold, unless a shorter one was requested, and no longer than the
/// client's owner allows.
bool hold_time(const SessionParameters& asked, const SessionParameters& granted,
               const GrantLimits& limits);
bool keep_alive(const SessionParameters& asked, const SessionParameters& granted,
                const GrantLimits& limits);

}  // namespace grant

/// The rules: one for each field of SessionParameters.
inline constexpr auto kParameterRules = [] {
  using P = SessionParameters;
  const auto rule = []<class Value>(const char* field, Value P::*value, ActedOnBy by,
                                    bool (*may_grant)(const P&, const P&, const GrantLimits&)) {
    return ParameterRule<Value>{field, value, by, may_grant};
  };
  using enum ActedOnBy;
  return std::tuple{rule("mode", &P::mode, bound, nullptr),
                    rule("projection", &P::projection, bound, nullptr),
                    rule("storage", &P::storage, bound, nullptr),
                    rule("side", &P::side, client, &grant::to_client),
                    rule("servo_period", &P::servo_period, client, nullptr),
                    rule("redundancy", &P::redundancy, client, &grant::traffic),
                    rule("operator_damping", &P::operator_damping, bound, nullptr),
                    rule("velocity_cutoff", &P::velocity_cutoff, server, nullptr),
                    rule("hold_time", &P::hold_time, client, &grant::hold_time),
                    rule("c1", &P::c1, bound, nullptr),
                    rule("c2", &P::c2, bound, nullptr),
                    rule("reference", &P::reference, bound, nullptr),
                    rule("coupling_stiffness", &P::coupling_stiffness, bound, nullptr),
                    rule("coupling_damping", &P::coupling_damping, bound, nullptr),
                    rule("tool_mass", &P::tool_mass, bound, nullptr),
                    rule("packet_interval", &P::packet_interval, client, &grant::traffic),
                    rule("batch", &P::batch, client, &grant::traffic),
                    rule("position_deadband", &P::position_deadband, client, &grant::traffic),
                    rule("force_deadband", &P::force_deadband, client, &grant::traffic),
                    rule("predictor", &P::predictor, client, &grant::traffic),
                    rule("keep_alive", &P::keep_alive, client, &grant::keep_alive),
                    rule("local_model", &P::local_model, client, &grant::traffic)};
}();

constexpr auto parameter_fields(const SessionParameters& p) {
  // A field added to or removed from SessionParameters does not compile here: give it a rule above,
  // then a name and a count here.
  [[maybe_unused]] const auto& [mode, projection, storage, side, servo_period, redundancy,
                                operator_damping, velocity_cutoff, hold_time, c1, c2, reference,
                                coupling_stiffness, coupling_damping, tool_mass, packet_interval,
                                batch, position_deadband, force_deadband, predictor, keep_alive,
                                local_model] = p;
  return std::integral_constant<std::size_t, 22>{};
}
inline constexpr std::size_t kParameterFields =
    decltype(parameter_fields(std::declval<SessionParameters>()))::value;
static_assert(std::tuple_size_v<decltype(kParameterRules)> == kParameterFields,
              "each field of SessionParameters has one rule");

/// The first field in which the two differ, with both values: "c1: asked 500, granted 400". Empty
/// if they are equal.
std::optional<std::string> difference(const SessionParameters& asked,
                                      const SessionParameters& granted);

/// The first field that a server may not grant in this way, in the same form. Precondition: both
/// are valid (validate()).
std::optional<std::string> forbidden_grant(const SessionParameters& asked,
                                           const SessionParameters& granted,
                                           const GrantLimits& limits = {});

/// The first field that cannot be changed at the server while a session runs, because its client
/// uses it, with the reason and the remedy.
std::optional<std::string> forbidden_change(const SessionParameters& running,
                                            const SessionParameters& wanted);

}  // namespace feltwire
