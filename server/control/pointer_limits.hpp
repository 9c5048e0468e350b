#pragma once
// What a session of role pointer may be, whoever asks for it.

#include <optional>
#include <string>

#include "protocol/wire/control.hpp"

namespace feltwire {

/// The hand of the live page is within these limits (sim/page_hand).
inline constexpr double kPointerForce = 10.0;   // [N] of the device, at most
inline constexpr double kPointerRate = 1000.0;  // [1/s] samples, at most

/// The error and the remedy, where a request to join as a pointer is beyond the limits. Nothing
/// where it is within them, or of another role.
std::optional<std::string> beyond_pointer(const control::JoinRequest& request);

}  // namespace feltwire
