#pragma once
// Authenticated encryption with associated data, by libsodium: AES-256-GCM (NIST SP 800-38D) where
// the CPU has instructions for it, ChaCha20-Poly1305 (RFC 8439) everywhere.

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "protocol/crypto/session_keys.hpp"

namespace feltwire {

inline constexpr std::size_t kTagSize = 16, kNonceSize = 12;  // [bytes]
using Nonce = std::array<std::uint8_t, kNonceSize>;

/// Whether this machine supports the suite: ChaCha20-Poly1305 always, AES-256-GCM with AES-NI and
/// PCLMUL.
bool supported(CipherSuite suite);
/// The fastest supported suite.
CipherSuite preferred_suite();

/// Forgeries that may be tried against one key before one of them succeeds with a probability of
/// 2^-57: 2^52 for AES-GCM, 2^36 for ChaCha20-Poly1305 (RFC 9001, 6.6).
constexpr std::uint64_t forgery_limit(CipherSuite suite) noexcept {
  constexpr int kAesGcm = 52, kChaCha20Poly1305 = 36;  // powers of two
  return std::uint64_t{1} << (suite == CipherSuite::aes_256_gcm ? kAesGcm : kChaCha20Poly1305);
}

/// A key prepared for its cipher. Fixed size, no allocation; it is wiped at its end.
class AeadKey {
 public:
  /// Throws std::invalid_argument if the suite is unknown or not supported here.
  AeadKey(CipherSuite suite, const Key& key);
  ~AeadKey();
  AeadKey(const AeadKey&) noexcept = default;
  AeadKey& operator=(const AeadKey&) noexcept = default;

  /// Writes ciphertext and tag, message.size() + kTagSize bytes, to `out`. Use each nonce only
  /// once.
  void seal(const Nonce& nonce, std::span<const std::uint8_t> associated,
            std::span<const std::uint8_t> message, std::uint8_t* out) const noexcept;

  /// Writes the message, sealed.size() - kTagSize bytes, to `out`. False if any sealed bit was
  /// changed; `out` is unspecified then. Precondition: sealed has at least kTagSize bytes.
  [[nodiscard]] bool open(const Nonce& nonce, std::span<const std::uint8_t> associated,
                          std::span<const std::uint8_t> sealed, std::uint8_t* out) const noexcept;

 private:
  static constexpr std::size_t kStateSize = 512;  // [bytes] AES: round keys and hash tables
  alignas(16) std::array<std::uint8_t, kStateSize> state_{};
  CipherSuite suite_;
};

}  // namespace feltwire
