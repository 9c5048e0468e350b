#pragma once

#include <sodium.h>

#include <array>
#include <cstdint>
#include <string_view>

namespace feltwire {

using Sha256 = std::array<std::uint8_t, crypto_hash_sha256_BYTES>;

inline Sha256 sha256(std::string_view bytes) noexcept {
  Sha256 hash;
  crypto_hash_sha256(hash.data(), reinterpret_cast<const std::uint8_t*>(bytes.data()),
                     bytes.size());
  return hash;
}

}  // namespace feltwire
