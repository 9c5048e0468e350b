#include "protocol/session/grant.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#include "core/base/visible_text.hpp"
#include "core/base/written_number.hpp"

namespace feltwire {
namespace {

constexpr std::array<const char*, 2> kAtTheJoin = {"asked", "granted"};

std::string text(double value) { return shortest_text(value); }
std::string text(int value) { return std::to_string(value); }
std::string text(const std::string& value) { return visible(value); }
std::string text(bool value) { return value ? "on" : "off"; }
std::string text(const std::optional<double>& value) { return value ? text(*value) : "not given"; }
template <class Choice>
requires std::is_enum_v<Choice> std::string text(Choice value) { return std::string(name(value)); }

/// Finds the first rule for which both sets of parameters have different values and `breaks`
/// returns true. Returns the field and both values, labelled with `words`.
template <class Breaks>
std::optional<std::string> first(const SessionParameters& one, const SessionParameters& other,
                                 std::array<const char*, 2> words, Breaks breaks) {
  std::optional<std::string> found;
  const auto look = [&](const auto& rule) {
    const auto &a = one.*rule.value, &b = other.*rule.value;
    if (found || a == b || !breaks(rule)) return;
    found =
        std::string(rule.field) + ": " + words[0] + " " + text(a) + ", " + words[1] + " " + text(b);
  };
  std::apply([&](const auto&... rules) { (look(rules), ...); }, kParameterRules);
  return found;
}

}  // namespace

bool grant::hold_time(const SessionParameters& asked, const SessionParameters& granted,
                      const GrantLimits& limits) {
  return granted.hold_time >= std::min(asked.hold_time, kShortestUsualHold) &&
         granted.hold_time <= std::max(asked.hold_time, limits.hold_time);
}

bool grant::keep_alive(const SessionParameters& asked, const SessionParameters& granted,
                       const GrantLimits&) {
  return granted.keep_alive <= std::max(asked.keep_alive, 0.5 * granted.hold_time);
}

std::optional<std::string> difference(const SessionParameters& asked,
                                      const SessionParameters& granted) {
  return first(asked, granted, kAtTheJoin, [](const auto&) { return true; });
}

std::optional<std::string> forbidden_grant(const SessionParameters& asked,
                                           const SessionParameters& granted,
                                           const GrantLimits& limits) {
  return first(asked, granted, kAtTheJoin, [&](const auto& rule) {
    return rule.may_grant == nullptr || !rule.may_grant(asked, granted, limits);
  });
}

std::optional<std::string> forbidden_change(const SessionParameters& running,
                                            const SessionParameters& wanted) {
  const bool server_bounds = running.side == BoundingSide::server;
  auto found = first(running, wanted, {"in force", "wanted"}, [&](const auto& rule) {
    return rule.acted_on_by == ActedOnBy::client ||
           (rule.acted_on_by == ActedOnBy::bound && !server_bounds);
  });
  if (found)
    *found +=
        "; this session's client acts on it, and it cannot change while the session runs: have the "
        "client leave and join again with other parameters";
  return found;
}

}  // namespace feltwire
