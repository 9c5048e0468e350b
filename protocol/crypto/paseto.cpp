#include "protocol/crypto/paseto.hpp"

#include <sodium.h>

#include <initializer_list>
#include <stdexcept>
#include <utility>
#include <vector>

namespace feltwire::paseto {
namespace {

constexpr std::string_view kHeader = "v4.public.";
constexpr int kBase64 = sodium_base64_VARIANT_URLSAFE_NO_PADDING;
using Bytes = std::vector<std::uint8_t>;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), kBase64), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), kBase64);
  text.pop_back();  // libsodium's terminating zero
  return text;
}

/// Without padding, and with no set bit behind the last byte.
std::optional<Bytes> from_base64(std::string_view text) {
  if (text.empty()) return Bytes();  // libsodium must not get a null pointer
  Bytes bytes(text.size());          // longer than needed
  std::size_t size = 0;
  const char* end = nullptr;
  if (sodium_base642bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &size, &end,
                        kBase64) != 0 ||
      end != text.data() + text.size())
    return std::nullopt;
  bytes.resize(size);
  return bytes;
}

void append_length(Bytes& to, std::uint64_t length) {
  constexpr std::uint64_t kMostLength = 0x7fffffffffffffff;  // the specification clears one bit
  for (int shift = 0; shift < 64; shift += 8)
    to.push_back(static_cast<std::uint8_t>((length & kMostLength) >> shift));
}

/// The pieces with their number and lengths, so that no other pieces give the same bytes.
Bytes pre_authentication_encoding(std::initializer_list<std::span<const std::uint8_t>> pieces) {
  Bytes encoded;
  append_length(encoded, pieces.size());
  for (const auto& piece : pieces) {
    append_length(encoded, piece.size());
    encoded.insert(encoded.end(), piece.begin(), piece.end());
  }
  return encoded;
}

struct Parts {
  Bytes message;  // with the signature behind it
  std::string footer;
};

std::optional<Parts> split(std::string_view token) {
  if (token.size() > kMaxToken || !token.starts_with(kHeader)) return std::nullopt;
  token.remove_prefix(kHeader.size());
  const std::size_t dot = token.find('.');
  const auto message = from_base64(token.substr(0, dot));
  if (!message || message->size() < crypto_sign_BYTES) return std::nullopt;
  Parts parts{*message, {}};
  if (dot == std::string_view::npos) return parts;
  const auto footer = from_base64(token.substr(dot + 1));
  if (!footer || footer->empty()) return std::nullopt;
  parts.footer.assign(footer->begin(), footer->end());
  return parts;
}

}  // namespace

SigningKey SigningKey::random() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
  std::array<std::uint8_t, kSeedSize> seed;
  randombytes_buf(seed.data(), seed.size());
  const SigningKey key(seed);
  sodium_memzero(seed.data(), seed.size());
  return key;
}

SigningKey::SigningKey(std::span<const std::uint8_t, kSeedSize> seed) {
  static_assert(crypto_sign_SECRETKEYBYTES == 64 && crypto_sign_PUBLICKEYBYTES == 32);
  crypto_sign_seed_keypair(public_key_.data(), secret_.data(), seed.data());
}

SigningKey::~SigningKey() { sodium_memzero(secret_.data(), secret_.size()); }

std::string key_id(const PublicKey& key) {
  const std::string head = "k4.pid.", text = head + "k4.public." + base64(key);
  std::array<std::uint8_t, 33> hash;
  crypto_generichash(hash.data(), hash.size(), bytes_of(text).data(), text.size(), nullptr, 0);
  return head + base64(hash);
}

std::string sign(std::string_view payload, const SigningKey& key, std::string_view footer,
                 std::string_view implicit) {
  const Bytes signed_bytes = pre_authentication_encoding(
      {bytes_of(kHeader), bytes_of(payload), bytes_of(footer), bytes_of(implicit)});
  Bytes message(payload.begin(), payload.end());
  message.resize(payload.size() + crypto_sign_BYTES);
  crypto_sign_detached(message.data() + payload.size(), nullptr, signed_bytes.data(),
                       signed_bytes.size(), key.secret().data());
  std::string token = std::string(kHeader) + base64(message);
  if (!footer.empty()) token += "." + base64(bytes_of(footer));
  return token;
}

std::optional<std::string> unverified_footer(std::string_view token) {
  auto parts = split(token);
  if (!parts) return std::nullopt;
  return std::move(parts->footer);
}

std::optional<std::string> verify(std::string_view token, const PublicKey& key,
                                  std::string_view implicit) {
  const auto parts = split(token);
  if (!parts) return std::nullopt;
  const auto signature = std::span(parts->message).last<crypto_sign_BYTES>();
  const auto payload = std::span(parts->message).first(parts->message.size() - signature.size());
  const Bytes signed_bytes = pre_authentication_encoding(
      {bytes_of(kHeader), payload, bytes_of(parts->footer), bytes_of(implicit)});
  if (crypto_sign_verify_detached(signature.data(), signed_bytes.data(), signed_bytes.size(),
                                  key.data()) != 0)
    return std::nullopt;
  return std::string(payload.begin(), payload.end());
}

}  // namespace feltwire::paseto
