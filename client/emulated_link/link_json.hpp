#pragma once
// A link in a report. It includes nlohmann's JSON, so only .cpp files that write a report include
// it.

#include <nlohmann/json.hpp>

#include "client/emulated_link/link.hpp"

namespace feltwire {

/// The text that the user gave; for each direction the parameters, in the units of that text, and
/// the counters.
nlohmann::ordered_json link_json(const TwoWayLink& link);

}  // namespace feltwire
