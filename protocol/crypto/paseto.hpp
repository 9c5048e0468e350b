#pragma once
// Signed texts as PASETO v4.public describes them (github.com/paseto-standard/paseto-spec,
// Version4.md), by libsodium's Ed25519. The form has a version and no choice of algorithms. It does
// not protect against a second use; the reader keeps a list for that.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace feltwire::paseto {

inline constexpr std::size_t kSeedSize = 32;    // [bytes]
inline constexpr std::size_t kMaxToken = 8192;  // [bytes] a longer text is not read
using PublicKey = std::array<std::uint8_t, 32>;

/// An Ed25519 key. Every copy is wiped when it is destroyed.
class SigningKey {
 public:
  /// A new key of the system's random numbers (end_without_random_numbers()).
  static SigningKey random();
  /// The key of a seed, which is as secret as the key.
  explicit SigningKey(std::span<const std::uint8_t, kSeedSize> seed);
  SigningKey(const SigningKey&) = default;
  SigningKey& operator=(const SigningKey&) = default;
  ~SigningKey();

  const PublicKey& public_key() const noexcept { return public_key_; }
  std::span<const std::uint8_t, 64> secret() const noexcept { return secret_; }

 private:
  std::array<std::uint8_t, 64> secret_{};  // seed and public key, as libsodium keeps it
  PublicKey public_key_{};
};

/// The name of a key, `k4.pid.` and 44 characters (PASERK, operations/ID.md).
std::string key_id(const PublicKey& key);

/// Returns the token. `footer` is signed and stays readable; `implicit` is signed and not sent: the
/// reader must give the same.
std::string sign(std::string_view payload, const SigningKey& key, std::string_view footer = {},
                 std::string_view implicit = {});

/// The footer of a token that nobody has verified yet; empty text if it has none. Empty for a text
/// that is no v4.public token.
std::optional<std::string> unverified_footer(std::string_view token);

/// The payload; empty unless this key has signed it, with this implicit assertion and its footer.
std::optional<std::string> verify(std::string_view token, const PublicKey& key,
                                  std::string_view implicit = {});

}  // namespace feltwire::paseto
