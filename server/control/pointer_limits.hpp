#pragma once
// The limits of a session of role pointer, for every client.

#include <optional>
#include <string>

#include "protocol/wire/control.hpp"

namespace feltwire {

/// The hand of the live page is within these limits (gateway/page_hand).
inline constexpr double kPointerForce = 10.0;   // [N] largest force of the device
inline constexpr double kPointerRate = 1000.0;  // [1/s] largest number of samples

/// Returns the error and the remedy if a request to join as a pointer is beyond the limits. Empty
/// if it is within them, or of another role.
std::optional<std::string> beyond_pointer(const control::JoinRequest& request);

}  // namespace feltwire
