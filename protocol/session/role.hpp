#pragma once
// The roles of a token: what its holder may do.

#include <array>
#include <cstdint>
#include <string_view>

namespace feltwire {

/// Each may what those before it may: an observer is shown the scene, feels nothing and moves
/// nothing, an operator acts, an admin lists and evicts sessions and reloads scenes.
enum class Role : std::uint8_t { observer, operator_, admin };

inline constexpr std::array<std::string_view, 3> kRoleNames = {"observer", "operator", "admin"};

std::string_view name(Role role);
/// Throws std::invalid_argument naming the choices when there is no such role.
Role role(std::string_view name);

constexpr bool covers(Role granted, Role wanted) { return granted >= wanted; }

}  // namespace feltwire
