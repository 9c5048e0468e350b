#include "protocol/crypto/aead.hpp"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

static_assert(kTagSize == crypto_aead_aes256gcm_ABYTES &&
              kTagSize == crypto_aead_chacha20poly1305_ietf_ABYTES);
static_assert(kNonceSize == crypto_aead_aes256gcm_NPUBBYTES &&
              kNonceSize == crypto_aead_chacha20poly1305_ietf_NPUBBYTES);
static_assert(kKeySize == crypto_aead_aes256gcm_KEYBYTES &&
              kKeySize == crypto_aead_chacha20poly1305_ietf_KEYBYTES);

/// Initializes libsodium once. This detects the features of the CPU.
void make_ready() {
  static const bool ready = ::sodium_init() >= 0;
  if (!ready) throw std::runtime_error("libsodium cannot be initialised");
}

const crypto_aead_aes256gcm_state* aes(const std::uint8_t* state) {
  return reinterpret_cast<const crypto_aead_aes256gcm_state*>(state);
}

}  // namespace

bool supported(CipherSuite suite) {
  make_ready();
  if (suite == CipherSuite::aes_256_gcm) return ::crypto_aead_aes256gcm_is_available() != 0;
  return suite == CipherSuite::chacha20_poly1305;
}

CipherSuite preferred_suite() {
  return supported(CipherSuite::aes_256_gcm) ? CipherSuite::aes_256_gcm
                                             : CipherSuite::chacha20_poly1305;
}

AeadKey::AeadKey(CipherSuite suite, const Key& key) : suite_(suite) {
  static_assert(sizeof(crypto_aead_aes256gcm_state) == kStateSize &&
                alignof(crypto_aead_aes256gcm_state) <= 16);
  if (!supported(suite))
    throw std::invalid_argument("cipher suite " + std::to_string(static_cast<int>(suite)) +
                                " is not supported on this machine; use chacha20_poly1305 (" +
                                std::to_string(static_cast<int>(CipherSuite::chacha20_poly1305)) +
                                ")");
  if (suite == CipherSuite::aes_256_gcm)
    ::crypto_aead_aes256gcm_beforenm(reinterpret_cast<crypto_aead_aes256gcm_state*>(state_.data()),
                                     key.data());
  else
    std::copy(key.begin(), key.end(), state_.begin());
}

AeadKey::~AeadKey() { ::sodium_memzero(state_.data(), state_.size()); }

void AeadKey::seal(const Nonce& nonce, std::span<const std::uint8_t> associated,
                   std::span<const std::uint8_t> message, std::uint8_t* out) const noexcept {
  if (suite_ == CipherSuite::aes_256_gcm)
    ::crypto_aead_aes256gcm_encrypt_afternm(out, nullptr, message.data(), message.size(),
                                            associated.data(), associated.size(), nullptr,
                                            nonce.data(), aes(state_.data()));
  else
    ::crypto_aead_chacha20poly1305_ietf_encrypt(out, nullptr, message.data(), message.size(),
                                                associated.data(), associated.size(), nullptr,
                                                nonce.data(), state_.data());
}

bool AeadKey::open(const Nonce& nonce, std::span<const std::uint8_t> associated,
                   std::span<const std::uint8_t> sealed, std::uint8_t* out) const noexcept {
  if (suite_ == CipherSuite::aes_256_gcm)
    return ::crypto_aead_aes256gcm_decrypt_afternm(
               out, nullptr, nullptr, sealed.data(), sealed.size(), associated.data(),
               associated.size(), nonce.data(), aes(state_.data())) == 0;
  return ::crypto_aead_chacha20poly1305_ietf_decrypt(
             out, nullptr, nullptr, sealed.data(), sealed.size(), associated.data(),
             associated.size(), nonce.data(), state_.data()) == 0;
}

}  // namespace feltwire
