#include "protocol/crypto/hkdf.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>

namespace feltwire {

void hkdf_expand(std::span<const std::uint8_t> key, std::string_view info,
                 std::span<std::uint8_t> out) noexcept {
  // RFC 5869: T(i) = HMAC(T(i - 1) info i).
  std::array<std::uint8_t, crypto_auth_hmacsha256_BYTES> block{};
  crypto_auth_hmacsha256_state state;
  std::uint8_t counter = 0;
  for (std::size_t done = 0; done < out.size();) {
    crypto_auth_hmacsha256_init(&state, key.data(), key.size());
    if (counter > 0) crypto_auth_hmacsha256_update(&state, block.data(), block.size());
    crypto_auth_hmacsha256_update(&state, reinterpret_cast<const unsigned char*>(info.data()),
                                  info.size());
    ++counter;
    crypto_auth_hmacsha256_update(&state, &counter, sizeof counter);
    crypto_auth_hmacsha256_final(&state, block.data());
    const std::size_t size = std::min(block.size(), out.size() - done);
    std::copy_n(block.begin(), size, out.data() + done);
    done += size;
  }
  sodium_memzero(&state, sizeof state);
  sodium_memzero(block.data(), block.size());
}

}  // namespace feltwire
