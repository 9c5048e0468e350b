#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/wire/control.hpp"
#include "server/scene/datagram_gate.hpp"
#include "server/scene/pace.hpp"
#include "server/scene/session_table.hpp"
#include "server/scene/world_clock.hpp"

namespace feltwire {

/// The counters of all stages of a scene.
struct SceneCounters : SessionTableCounters, DatagramCounters, WorldClockCounters, PaceCounters {};

/// The counters of a scene with their names in the summary, without the drops by reason.
std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(const SceneCounters& c);
/// With the drops by reason, for admins.
control::Counters counter_list(const SceneCounters& counters);

}  // namespace feltwire
