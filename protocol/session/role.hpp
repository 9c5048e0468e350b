#pragma once
// The roles of a token: the rights of its holder.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace feltwire {

/// The numbers are the wire's. Each role includes the rights of those below it in rank(): an
/// observer sees the scene, feels nothing and moves nothing; a pointer holds a small hand, that of
/// the live page; an operator acts with any device; an admin lists and evicts sessions, reloads
/// scenes and changes them. A follower is separate: a robot has the robot's seat of a scene and no
/// other right, and only a follower may take that seat.
enum class Role : std::uint8_t { observer, operator_, admin, pointer, follower };

inline constexpr std::array<std::string_view, 5> kRoleNames = {"observer", "operator", "admin",
                                                               "pointer", "follower"};

std::string_view name(Role role);
/// Whether the role has a hand that feels the scene.
constexpr bool feels(Role role) { return role != Role::observer && role != Role::follower; }
/// Throws std::invalid_argument that lists the choices if there is no such role.
Role role(std::string_view name);

/// From 0. Only the observer is below the pointer. A follower has no rank.
constexpr int rank(Role role) {
  constexpr std::array<int, 5> kRanks = {0, 2, 3, 1, -1};
  return kRanks[static_cast<std::size_t>(role)];
}
constexpr bool covers(Role granted, Role wanted) {
  if (granted == Role::follower || wanted == Role::follower) return granted == wanted;
  return rank(granted) >= rank(wanted);
}

}  // namespace feltwire
