#pragma once
// The keys of a session, which only its two ends know.

#include <array>
#include <cstdint>

namespace feltwire {

/// The cipher of the datagrams; both have a 32-byte key, a 12-byte nonce and a 16-byte tag.
enum class CipherSuite : std::uint8_t { aes_256_gcm = 1, chacha20_poly1305 = 2 };

inline constexpr std::size_t kKeySize = 32;  // [bytes]
using Key = std::array<std::uint8_t, kKeySize>;

/// The keys of one session. They are never used for another session or after the end of this one.
/// Every copy is wiped when it is destroyed.
struct SessionKeys {
  CipherSuite suite = CipherSuite::chacha20_poly1305;
  Key up{};    // client to server
  Key down{};  // server to client

  ~SessionKeys();
};

/// New keys of the system's random numbers, for one session (end_without_random_numbers()).
SessionKeys random_session_keys(CipherSuite suite);

}  // namespace feltwire
