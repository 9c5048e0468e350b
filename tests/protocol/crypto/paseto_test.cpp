// Tests signed texts against the official test vectors (github.com/paseto-standard/test-vectors,
// v4.json and PASERK/k4.pid.json, at 32d74065).

#include "protocol/crypto/paseto.hpp"

#include <gtest/gtest.h>
#include <sodium.h>

#include <utility>
#include <vector>

namespace feltwire::paseto_test {
namespace {

using namespace paseto;

struct Vector {
  const char *name, *token, *payload, *footer, *implicit;
};

// All of v4.json that succeed for v4.public.
const std::vector<Vector> kGood = {
    {"4-S-1",
     "v4.public.eyJkYXRhIjoidGhpcyBpcyBhIHNpZ25lZCBtZXNzYWdlIiwiZXhwIjoiMjAyMi0wMS0w"
     "MVQwMDowMDowMCswMDowMCJ9bg_XBBzds8lTZShVlwwKSgeKpLT3yukTw6JUz3W4h_ExsQV-P0V54z"
     "emZDcAxFaSeef1QlXEFtkqxT1ciiQEDA",
     "{\"data\":\"this is a signed message\",\"exp\":\"2022-01-01T00:00:00+00:00\"}", "", ""},
    {"4-S-2",
     "v4.public.eyJkYXRhIjoidGhpcyBpcyBhIHNpZ25lZCBtZXNzYWdlIiwiZXhwIjoiMjAyMi0wMS0w"
     "MVQwMDowMDowMCswMDowMCJ9v3Jt8mx_TdM2ceTGoqwrh4yDFn0XsHvvV_D0DtwQxVrJEBMl0F2caA"
     "dgnpKlt4p7xBnx1HcO-SPo8FPp214HDw.eyJraWQiOiJ6VmhNaVBCUDlmUmYyc25FY1Q3Z0ZUaW9lQ"
     "TlDT2NOeTlEZmdMMVc2MGhhTiJ9",
     "{\"data\":\"this is a signed message\",\"exp\":\"2022-01-01T00:00:00+00:00\"}",
     "{\"kid\":\"zVhMiPBP9fRf2snEcT7gFTioeA9COcNy9DfgL1W60haN\"}", ""},
    {"4-S-3",
     "v4.public.eyJkYXRhIjoidGhpcyBpcyBhIHNpZ25lZCBtZXNzYWdlIiwiZXhwIjoiMjAyMi0wMS0w"
     "MVQwMDowMDowMCswMDowMCJ9NPWciuD3d0o5eXJXG5pJy-DiVEoyPYWs1YSTwWHNJq6DZD3je5gf-0"
     "M4JR9ipdUSJbIovzmBECeaWmaqcaP0DQ.eyJraWQiOiJ6VmhNaVBCUDlmUmYyc25FY1Q3Z0ZUaW9lQ"
     "TlDT2NOeTlEZmdMMVc2MGhhTiJ9",
     "{\"data\":\"this is a signed message\",\"exp\":\"2022-01-01T00:00:00+00:00\"}",
     "{\"kid\":\"zVhMiPBP9fRf2snEcT7gFTioeA9COcNy9DfgL1W60haN\"}", "{\"test-vector\":\"4-S-3\"}"},
};
// All that must fail: other versions and purposes, a symmetric key's, padded base64.
const std::vector<Vector> kBad = {
    {"4-F-1",
     "v4.local.vngXfCISbnKgiP6VWGuOSlYrFYU300fy9ijW33rznDYgxHNPwWluAY2Bgb0z54CUs6aYY"
     "kIJ-bOOOmJHPuX_34Agt_IPlNdGDpRdGNnBz2MpWJvB3cttheEc1uyCEYltj7wBQQYX.YXJiaXRyYX"
     "J5LXN0cmluZy10aGF0LWlzbid0LWpzb24",
     "", "arbitrary-string-that-isn't-json", "{\"test-vector\":\"4-F-1\"}"},
    {"4-F-2",
     "v4.public.eyJpbnZhbGlkIjoidGhpcyBzaG91bGQgbmV2ZXIgZGVjb2RlIn22Sp4gjCaUw0c7EH84"
     "ZSm_jN_Qr41MrgLNu5LIBCzUr1pn3Z-Wukg9h3ceplWigpoHaTLcwxj0NsI1vjTh67YB.eyJraWQiO"
     "iJ6VmhNaVBCUDlmUmYyc25FY1Q3Z0ZUaW9lQTlDT2NOeTlEZmdMMVc2MGhhTiJ9",
     "", "{\"kid\":\"zVhMiPBP9fRf2snEcT7gFTioeA9COcNy9DfgL1W60haN\"}",
     "{\"test-vector\":\"4-F-2\"}"},
    {"4-F-3",
     "v3.local.23e_2PiqpQBPvRFKzB0zHhjmxK3sKo2grFZRRLM-U7L0a8uHxuF9RlVz3Ic6WmdUUWTxC"
     "aYycwWV1yM8gKbZB2JhygDMKvHQ7eBf8GtF0r3K0Q_gF1PXOxcOgztak1eD1dPe9rLVMSgR0nHJXeI"
     "GYVuVrVoLWQ.YXJiaXRyYXJ5LXN0cmluZy10aGF0LWlzbid0LWpzb24",
     "", "arbitrary-string-that-isn't-json", "{\"test-vector\":\"4-F-3\"}"},
    {"4-F-4",
     "v4.local.AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAQAr68PS4AXe7If_ZgesdkUMvSw"
     "scFlAl1pk5HC0e8kApeaqMfGo_7OpBnwJOAbY9V7WU6abu74MmcUE8YWAiaArVI8XJ5hOb_4v9RmDk"
     "neN0S92dx0OW4pgy7omxgf3S8c3LlQh",
     "", "", ""},
    {"4-F-5",
     "v4.local.32VIErrEkmY4JVILovbmfPXKW9wT1OdQepjMTC_MOtjA4kiqw7_tcaOM5GNEcnTxl60Wk"
     "wMsYXw6FSNb_UdJPXjpzm0KW9ojM5f4O2mRvE2IcweP-PRdoHjd5-RHCiExR1IK6t4x-RMNXtQNbz7"
     "FvFZ_G-lFpk5RG3EOrwDL6CgDqcerSQ==.eyJraWQiOiJ6VmhNaVBCUDlmUmYyc25FY1Q3Z0ZUaW9l"
     "QTlDT2NOeTlEZmdMMVc2MGhhTiJ9",
     "", "{\"kid\":\"zVhMiPBP9fRf2snEcT7gFTioeA9COcNy9DfgL1W60haN\"}", ""},
};
constexpr const char* kSeed = "b4cbfb43df4ce210727d953e4a713307fa19bb7d9f85041438d9e11b942a3774";
constexpr const char* kPublic = "1eb9dbbbbc047c03fd70604e0071f0987e16b28b757225c11f00415d0e20b1a2";

std::array<std::uint8_t, 32> from_hex(const std::string& text) {
  std::array<std::uint8_t, 32> bytes{};
  EXPECT_EQ(sodium_hex2bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, nullptr,
                           nullptr),
            0);
  return bytes;
}

TEST(Paseto, MakesAndReadsTheOfficialTokens) {
  const SigningKey key(from_hex(kSeed));
  EXPECT_EQ(key.public_key(), from_hex(kPublic));
  ASSERT_EQ(kGood.size(), 3u);
  for (const Vector& vector : kGood) {
    EXPECT_EQ(sign(vector.payload, key, vector.footer, vector.implicit), vector.token)
        << vector.name;
    EXPECT_EQ(verify(vector.token, key.public_key(), vector.implicit), vector.payload)
        << vector.name;
    EXPECT_EQ(unverified_footer(vector.token), vector.footer) << vector.name;
  }
}

TEST(Paseto, RefusesTheOfficialBadTokens) {
  ASSERT_EQ(kBad.size(), 5u);
  for (const Vector& vector : kBad) {
    for (const char* const key :
         {kPublic, "707172737475767778797a7b7c7d7e7f808182838485868788898a8b8c8d8e8f"})
      EXPECT_EQ(verify(vector.token, from_hex(key), vector.implicit), std::nullopt) << vector.name;
  }
}

TEST(Paseto, NamesKeysAsTheOfficialVectorsDo) {
  const std::pair<const char*, const char*> names[] = {
      {"0000000000000000000000000000000000000000000000000000000000000000",
       "k4.pid.S_XQmeEwHbbvRmiyfXfHYpLGjXGzjTRSDoT1YtTakWFE"},
      {"707172737475767778797a7b7c7d7e7f808182838485868788898a8b8c8d8e8f",
       "k4.pid.9ShR3xc8-qVJ_di0tc9nx0IDIqbatdeM2mqLFBJsKRHs"},
      {"707172737475767778797a7b7c7d7e7f808182838485868788898a8b8c8d8e90",
       "k4.pid.-nyvbaTz8U6TQz7OZWW-iB3va31iAxIpUgzUcVQVmW9A"}};
  for (const auto& [key, name] : names) EXPECT_EQ(key_id(from_hex(key)), name);
}

TEST(Paseto, AChangeOfAnyCharacterIsSeen) {
  const SigningKey key(from_hex(kSeed));
  const std::string token = kGood[2].token;
  for (std::size_t i = 0; i < token.size(); ++i) {
    std::string changed = token;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_EQ(verify(changed, key.public_key(), kGood[2].implicit), std::nullopt) << i;
    EXPECT_EQ(verify(token.substr(0, i), key.public_key(), kGood[2].implicit), std::nullopt) << i;
  }
  EXPECT_EQ(verify(token + ".", key.public_key(), kGood[2].implicit), std::nullopt);
  EXPECT_EQ(verify(token + "=", key.public_key(), kGood[2].implicit), std::nullopt);
  EXPECT_EQ(verify(token, key.public_key(), "another"), std::nullopt);
  EXPECT_EQ(verify(token, SigningKey::random().public_key(), kGood[2].implicit), std::nullopt);
}

TEST(Paseto, PiecesCannotMoveOverTheirBorders) {
  const SigningKey key = SigningKey::random();
  const std::string token = sign("ab", key, "cd", "ef");
  EXPECT_EQ(verify(token, key.public_key(), "ef"), "ab");
  const auto same_signature = [&](const char* payload, const char* footer, const char* implicit) {
    return sign(payload, key, footer, implicit).substr(0, token.rfind('.')) ==
           token.substr(0, token.rfind('.'));
  };
  EXPECT_TRUE(same_signature("ab", "cd", "ef"));
  EXPECT_FALSE(same_signature("ab", "cde", "f"));
  EXPECT_FALSE(same_signature("ab", "c", "def"));
}

TEST(Paseto, ALongTextIsNotRead) {
  const SigningKey key = SigningKey::random();
  const std::string token = sign(std::string(kMaxToken, 'x'), key);
  EXPECT_EQ(verify(token, key.public_key()), std::nullopt);
  EXPECT_EQ(unverified_footer(token), std::nullopt);
}

}  // namespace
}  // namespace feltwire::paseto_test
