#pragma once
// A link in a report. Includes nlohmann's JSON: for .cpp files that write one.

#include <nlohmann/json.hpp>

#include "client/emulated_link/link.hpp"

namespace feltwire {

/// What was asked for, and of each direction the parameters, in the units of that text, and the
/// counters.
nlohmann::ordered_json link_json(const TwoWayLink& link);

}  // namespace feltwire
