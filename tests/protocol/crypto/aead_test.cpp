// Compares the ciphers and the key derivation with published vectors. libsodium, as we call it,
// must follow the standards.

#include "protocol/crypto/aead.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/crypto/hkdf.hpp"

namespace feltwire::aead_test {
namespace {

using Octets = std::vector<std::uint8_t>;

Octets hex(std::string_view text) {
  Octets bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes.push_back(
        static_cast<std::uint8_t>(std::stoi(std::string(text.substr(i, 2)), nullptr, 16)));
  return bytes;
}

struct Vector {
  CipherSuite suite;
  const char *key, *nonce, *associated, *message, *sealed;
};

void expect_vector(const Vector& v) {
  Key key;
  Nonce nonce;
  const Octets k = hex(v.key), n = hex(v.nonce), a = hex(v.associated), m = hex(v.message);
  ASSERT_EQ(k.size(), key.size());
  ASSERT_EQ(n.size(), nonce.size());
  std::copy(k.begin(), k.end(), key.begin());
  std::copy(n.begin(), n.end(), nonce.begin());
  const AeadKey ready(v.suite, key);
  Octets sealed(m.size() + kTagSize);
  ready.seal(nonce, a, m, sealed.data());
  EXPECT_EQ(sealed, hex(v.sealed));
  Octets message(m.size());
  EXPECT_TRUE(ready.open(nonce, a, sealed, message.data()));
  EXPECT_EQ(message, m);
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    sealed[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_FALSE(ready.open(nonce, a, sealed, message.data())) << bit;
    sealed[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
  }
}

/// McGrew, Viega: The Galois/Counter Mode of Operation, test cases 13 to 16.
TEST(Aead, Aes256GcmIsNists) {
  if (!supported(CipherSuite::aes_256_gcm)) GTEST_SKIP() << "this CPU has no AES instructions";
  const auto aes = CipherSuite::aes_256_gcm;
  const char* const zero_key = "0000000000000000000000000000000000000000000000000000000000000000";
  const char* const zero_nonce = "000000000000000000000000";
  expect_vector({aes, zero_key, zero_nonce, "", "", "530f8afbc74536b9a963b4f1c4cb738b"});
  expect_vector({aes, zero_key, zero_nonce, "", "00000000000000000000000000000000",
                 "cea7403d4d606b6e074ec5d3baf39d18d0d1c8a799996bf0265b98b5d48ab919"});
  const char* const key = "feffe9928665731c6d6a8f9467308308feffe9928665731c6d6a8f9467308308";
  const char* const nonce = "cafebabefacedbaddecaf888";
  expect_vector({aes, key, nonce, "",
                 "d9313225f88406e5a55909c5aff5269a86a7a9531534f7da2e4c303d8a318a72"
                 "1c3c0c95956809532fcf0e2449a6b525b16aedf5aa0de657ba637b391aafd255",
                 "522dc1f099567d07f47f37a32a84427d643a8cdcbfe5c0c97598a2bd2555d1aa"
                 "8cb08e48590dbb3da7b08b1056828838c5f61e6393ba7a0abcc9f662898015ad"
                 "b094dac5d93471bdec1a502270e3cc6c"});
  expect_vector({aes, key, nonce, "feedfacedeadbeeffeedfacedeadbeefabaddad2",
                 "d9313225f88406e5a55909c5aff5269a86a7a9531534f7da2e4c303d8a318a72"
                 "1c3c0c95956809532fcf0e2449a6b525b16aedf5aa0de657ba637b39",
                 "522dc1f099567d07f47f37a32a84427d643a8cdcbfe5c0c97598a2bd2555d1aa"
                 "8cb08e48590dbb3da7b08b1056828838c5f61e6393ba7a0abcc9f662"
                 "76fc6ece0f4e1768cddf8853bb2d551b"});
}

/// RFC 8439, 2.8.2.
TEST(Aead, ChaCha20Poly1305IsTheRfcs) {
  expect_vector({CipherSuite::chacha20_poly1305,
                 "808182838485868788898a8b8c8d8e8f909192939495969798999a9b9c9d9e9f",
                 "070000004041424344454647", "50515253c0c1c2c3c4c5c6c7",
                 "4c616469657320616e642047656e746c656d656e206f662074686520636c6173"
                 "73206f66202739393a204966204920636f756c64206f6666657220796f75206f"
                 "6e6c79206f6e652074697020666f7220746865206675747572652c2073756e73"
                 "637265656e20776f756c642062652069742e",
                 "d31a8d34648e60db7b86afbc53ef7ec2a4aded51296e08fea9e2b5a736ee62d6"
                 "3dbea45e8ca9671282fafb69da92728b1a71de0a9e060b2905d6a5b67ecd3b36"
                 "92ddbd7f2d778b8c9803aee328091b58fab324e4fad675945585808b4831d7bc"
                 "3ff4def08e4b7a9de576d26586cec64b61161ae10b594f09e26a7e902ecbd060"
                 "0691"});
}

TEST(Aead, WhatIsNoSuiteIsRefused) {
  EXPECT_FALSE(supported(static_cast<CipherSuite>(0)));
  EXPECT_THROW(AeadKey(static_cast<CipherSuite>(3), {}), std::invalid_argument);
  EXPECT_TRUE(supported(preferred_suite()));
  EXPECT_EQ(forgery_limit(CipherSuite::aes_256_gcm), 4503599627370496u);
  EXPECT_EQ(forgery_limit(CipherSuite::chacha20_poly1305), 68719476736u);
}

/// RFC 5869, A.1 to A.3.
TEST(Hkdf, ExpandIsTheRfcs) {
  struct Case {
    const char *key, *out;
  };
  std::string long_info;
  for (int byte = 0xb0; byte <= 0xff; ++byte) long_info += static_cast<char>(byte);
  const Octets one = hex("f0f1f2f3f4f5f6f7f8f9");
  const std::vector<std::pair<Case, std::string>> cases = {
      {{"077709362c2e32df0ddc3f0dc47bba6390b6c73bb50f9c3122ec844ad7c2b3e5",
        "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865"},
       std::string(one.begin(), one.end())},
      {{"06a6b88c5853361a06104c9ceb35b45cef760014904671014a193f40c15fc244",
        "b11e398dc80327a1c8e7f78c596a49344f012eda2d4efad8a050cc4c19afa97c"
        "59045a99cac7827271cb41c65e590e09da3275600c2f09b8367793a9aca3db71"
        "cc30c58179ec3e87c14c01d5c1f3434f1d87"},
       long_info},
      {{"19ef24a32c717b167f33a91d6f648bdf96596776afdb6377ac434c1c293ccb04",
        "8da4e775a563c18f715f802a063c5a31b8a11f5c5ee1879ec3454e5f3c738d2d9d201395faa4b61a96c8"},
       ""}};
  for (const auto& [c, info] : cases) {
    const Octets expected = hex(c.out);
    Octets out(expected.size());
    hkdf_expand(hex(c.key), info, out);
    EXPECT_EQ(out, expected);
  }
}

}  // namespace
}  // namespace feltwire::aead_test
