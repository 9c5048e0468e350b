#pragma once
// The keys of a session travel in the answer to its JoinRequest.

#include "protocol/crypto/session_keys.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// Puts the keys into the answer.
void put_keys(const SessionKeys& keys, control::JoinAccepted& accepted);

/// Returns the keys in the answer, and wipes them there. Throws std::invalid_argument that names
/// the field if a secret does not have kKeySize bytes, or if both are equal: then the two
/// directions would use the same nonces with the same key.
SessionKeys take_keys(control::JoinAccepted& accepted);

}  // namespace feltwire
