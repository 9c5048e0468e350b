#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "server/scene/scene_sessions.hpp"

namespace feltwire {

/// The counters of a scene with their names in the summary, without the drops by reason.
std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(const SceneCounters& c);

}  // namespace feltwire
