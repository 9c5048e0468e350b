#pragma once
// The sessions that are slowed down while a scene's thread is short of time.

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace feltwire {

enum class Slowed : std::uint8_t { observers, hands };
inline constexpr std::array<std::string_view, 2> kSlowedNames = {"observers", "hands"};

/// The kinds of sessions in the order in which they are slowed down (server/scene/pace.hpp). A kind
/// that is not there is never slowed down.
using SlowDownOrder = std::vector<Slowed>;

/// Reads "observers,hands"; "off": none. Throws std::invalid_argument.
SlowDownOrder slow_down_order(std::string_view text);

}  // namespace feltwire
