#pragma once
// The keys of a host's tickets in a file, so that a host that starts again signs with the same key.

#include <filesystem>
#include <vector>

#include "protocol/crypto/paseto.hpp"

namespace feltwire {

/// Reads the keys, the signing one first; one or two. Makes the file with a new key if it is
/// missing, for its owner only. Throws FileError if it cannot be read or written, has other
/// contents, or is open to others than its owner.
std::vector<paseto::SigningKey> ticket_keys(const std::filesystem::path& file);

/// Replaces the file as a whole. Throws FileError.
void write_ticket_keys(const std::filesystem::path& file,
                       const std::vector<paseto::SigningKey>& keys);

}  // namespace feltwire
