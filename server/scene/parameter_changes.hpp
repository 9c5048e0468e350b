#pragma once

#include <string>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// The differences, for the log: "hold_time 0.1 -> 0.2, mode contact_frame -> none"; "nothing
/// changed".
std::string changes(const SessionParameters& before, const SessionParameters& after);

}  // namespace feltwire
