#pragma once
// A link in a report. Includes nlohmann's JSON: for .cpp files that write one.

#include <nlohmann/json.hpp>

#include "client/emulated_link/link.hpp"

namespace feltwire {

/// The text that was given, and for each direction the parameters (in the units of that text) and
/// the counters.
nlohmann::ordered_json link_json(const TwoWayLink& link);

}  // namespace feltwire
