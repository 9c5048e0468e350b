#pragma once
// The server's certificate and its key.

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/tls.hpp"

namespace feltwire {

struct Identity {
  std::string certificate;  // PEM, followed by its chain if there is one
  Secret key;               // PEM
};

/// Makes a new P-256 key and a self-signed certificate for ten years, with these names (DNS names
/// and IP addresses). Throws std::runtime_error.
Identity make_identity(const std::vector<std::string>& names);

/// Reads both files. Throws FileError if one cannot be read or they do not belong together.
Identity load_identity(const std::filesystem::path& certificate, const std::filesystem::path& key);

/// The fingerprint of the first certificate. Throws std::runtime_error.
Fingerprint fingerprint(const Identity& identity);

}  // namespace feltwire
