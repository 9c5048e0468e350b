#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/teleoperation/link_states.hpp"

namespace feltwire {

/// The changes of the state between hand and robot, for the report of either.
inline nlohmann::ordered_json link_states_json(const LinkStates& states) {
  nlohmann::ordered_json changes = nlohmann::ordered_json::array();
  for (const LinkStates::Change& change : states.changes())
    changes.push_back({{"time_s", change.time},
                       {"seat", change.seat},
                       {"state", std::string(name(change.state))}});
  return {{"changes", std::move(changes)}, {"left_out", states.left_out()}};
}

}  // namespace feltwire
