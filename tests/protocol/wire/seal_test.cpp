// Tests sealed datagrams: the protocol's bytes, and the refusal of everything else.

#include "protocol/wire/seal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "tests/protocol/make.hpp"
#include "tests/protocol/sealing.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::seal_test {
namespace {

using namespace test::sealing;
using test::keys;

using Sealing = test::sealing::Fixture;
INSTANTIATE_TEST_SUITE_P(Suites, Sealing, ::testing::ValuesIn(test::suites()),
                         [](const auto& suite) {
                           return suite.param == CipherSuite::aes_256_gcm ? "Aes256Gcm"
                                                                          : "ChaCha20Poly1305";
                         });

std::string spaced_hex(Bytes bytes) {
  std::string text;
  constexpr const char* kDigits = "0123456789abcdef";
  for (const std::uint8_t byte : bytes) text += {kDigits[byte >> 4], kDigits[byte & 15], ' '};
  text.pop_back();
  return text;
}

/// Returns the text with a blank for every run of whitespace.
std::string protocol_text() {
  std::ifstream file(std::string(FELTWIRE_SOURCE_DIR) + "/protocol/PROTOCOL.md");
  std::string text, word;
  while (file >> word) text += word + ' ';
  return text;
}

/// The example in PROTOCOL.md has numbers from another implementation (Python's cryptography). Two
/// implementations must therefore agree.
TEST_P(Sealing, BytesAreTheProtocols) {
  Key secret;
  for (std::size_t i = 0; i < secret.size(); ++i) secret[i] = static_cast<std::uint8_t>(i);
  Encoder encoder;
  DatagramBuffer out;
  const std::string text = protocol_text();
  for (const std::uint64_t sent : {std::uint64_t{0}, kBorder - 1}) {
    Sealer sealer(GetParam(), secret, sent);
    const Bytes sealed =
        sealer.seal(DatagramKind::goodbye, kSession, encoder.goodbye(GoodbyeReason::evicted), out);
    EXPECT_NE(text.find(spaced_hex(sealed)), std::string::npos) << spaced_hex(sealed);
  }
  EXPECT_NE(text.find(spaced_hex(encoder.goodbye(GoodbyeReason::evicted))), std::string::npos)
      << spaced_hex(encoder.goodbye(GoodbyeReason::evicted));
  for (const Key& key : {sealing_key(secret), next_secret(secret)})
    EXPECT_NE(text.find(spaced_hex(key)), std::string::npos);
}

TEST_P(Sealing, EverySizeGoesAndComes) {
  Sealer sealer(GetParam(), session_keys.up);
  Opener opener(GetParam(), session_keys.up);
  DatagramBuffer out;
  for (std::size_t size = 0; size <= kMaxPayload; ++size) {
    Octets message(size);
    for (std::size_t i = 0; i < size; ++i) message[i] = static_cast<std::uint8_t>(i * size);
    const Bytes sealed = sealer.seal(DatagramKind::samples, kSession, message, out);
    ASSERT_EQ(sealed.size(), size + kOverhead);
    const Read got = read(opener, sealed);
    ASSERT_EQ(got.drop, DropReason::none);
    ASSERT_EQ(got.payload, message);
  }
  EXPECT_EQ(opener.highest(), kMaxPayload + 1);
  // A payload that is too long must not be sent and must use no number.
  EXPECT_TRUE(sealer.seal(DatagramKind::samples, kSession, Octets(kMaxPayload + 1), out).empty());
  EXPECT_EQ(sealer.sent(), kMaxPayload + 1);
}

/// The sealed bytes must not contain the payload.
TEST_P(Sealing, PayloadsAreHidden) {
  const Octets sealed = up.datagram(1, payload);
  EXPECT_EQ(std::search(sealed.begin(), sealed.end(), payload.begin(), payload.begin() + 8),
            sealed.end());
  EXPECT_NE(octets(Bytes(up.datagram(2, payload)).subspan(kHeaderSize)),
            octets(Bytes(sealed).subspan(kHeaderSize)));
}

TEST_P(Sealing, EveryBitOfADatagramCounts) {
  Opener opener(GetParam(), session_keys.up);
  Octets datagram = up.datagram(7, payload);
  for (std::size_t bit = 0; bit < 8 * datagram.size(); ++bit) {
    datagram[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const Read got = read(opener, datagram);
    EXPECT_NE(got.drop, DropReason::none) << bit;
    // After magic, version, kind and reserved, only the seal detects a change.
    if (bit >= 64) {
      EXPECT_EQ(got.drop, DropReason::sealed) << bit;
    }
    EXPECT_TRUE(got.payload.empty());
    datagram[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
  }
  EXPECT_EQ(opener.highest(), 0u);
  EXPECT_EQ(read(opener, datagram).drop, DropReason::none);  // The forgeries must have no effect.
}

TEST_P(Sealing, EveryTruncationAndExtensionIsRefused) {
  Opener opener(GetParam(), session_keys.up);
  const Octets datagram = up.datagram(1, payload);
  for (std::size_t size = 0; size < datagram.size(); ++size)
    EXPECT_EQ(read(opener, Bytes(datagram).first(size)).drop,
              size < kMinDatagram ? DropReason::size : DropReason::sealed);
  Octets longer = datagram;
  while (longer.size() < kMaxDatagram) {
    longer.push_back(0);
    EXPECT_EQ(read(opener, longer).drop, DropReason::sealed);
  }
  longer.push_back(0);
  EXPECT_EQ(read(opener, longer).drop, DropReason::size);
  EXPECT_EQ(read(opener, datagram).drop, DropReason::none);
}

TEST_P(Sealing, NothingIsOfUseElsewhere) {
  const Octets datagram = up.datagram(1, payload);
  const SessionKeys other = keys(kSession + 1, GetParam());
  for (const Key& wrong : {session_keys.down, other.up, other.down}) {
    Opener opener(GetParam(), wrong);
    EXPECT_EQ(read(opener, datagram).drop, DropReason::sealed);
    EXPECT_EQ(opener.highest(), 0u);
  }
  // The headers have another session, number or kind, or the tag belongs to another datagram.
  Opener opener(GetParam(), session_keys.up);
  Octets spliced = datagram;
  write_header(spliced, {DatagramKind::samples, kSession + 1, 1});
  EXPECT_EQ(read(opener, spliced).drop, DropReason::sealed);
  write_header(spliced, {DatagramKind::samples, kSession, 2});
  EXPECT_EQ(read(opener, spliced).drop, DropReason::sealed);
  write_header(spliced, {DatagramKind::goodbye, kSession, 1});
  EXPECT_EQ(read(opener, spliced).drop, DropReason::sealed);
  const Octets second = up.datagram(2, payload);
  std::copy(second.end() - kTagSize, second.end(), spliced.end() - kTagSize);
  EXPECT_EQ(read(opener, spliced).drop, DropReason::sealed);
  EXPECT_EQ(opener.forgeries(), 4u);
  EXPECT_EQ(read(opener, datagram).drop, DropReason::none);
}

TEST_P(Sealing, AReplayIsRefusedInAndOutOfTheWindow) {
  Opener opener(GetParam(), session_keys.up);
  for (const std::uint64_t number : {3u, 1u, 2000u, 1500u, 977u})
    EXPECT_EQ(read(opener, up.datagram(number, payload)).drop, DropReason::none) << number;
  for (const std::uint64_t number : {3u, 1u, 2000u, 1500u, 977u, 976u})
    EXPECT_EQ(read(opener, up.datagram(number, payload)).drop, DropReason::packet_number) << number;
  EXPECT_EQ(opener.forgeries(), 0u);
}

/// Forged numbers must change neither the window nor the keys.
TEST_P(Sealing, ForgedNumbersMoveNothing) {
  Opener opener(GetParam(), session_keys.up);
  EXPECT_EQ(read(opener, up.datagram(1, payload)).drop, DropReason::none);
  Octets forged = up.datagram(2, payload);
  for (const std::uint64_t number : {std::uint64_t{3}, std::uint64_t{5000}, kBorder - 1, kBorder,
                                     kBorder + 5, 2 * kBorder, 7 * kBorder, kLastPacketNumber}) {
    write_header(forged, {DatagramKind::samples, kSession, number});
    for (int again = 0; again < 3; ++again)
      EXPECT_EQ(read(opener, forged).drop, DropReason::sealed) << number;
  }
  EXPECT_EQ(opener.highest(), 1u);
  EXPECT_EQ(read(opener, up.datagram(2, payload)).drop, DropReason::none);
  EXPECT_EQ(opener.highest(), 2u);
}

TEST_P(Sealing, AMovedSealerSealsNoMore) {
  Sealer first(GetParam(), session_keys.up);
  DatagramBuffer out;
  const Octets one = octets(first.seal(DatagramKind::samples, kSession, payload, out));
  Sealer second(std::move(first));
  EXPECT_TRUE(first.seal(DatagramKind::samples, kSession, payload, out).empty());  // NOLINT
  const Octets two = octets(second.seal(DatagramKind::samples, kSession, payload, out));
  EXPECT_EQ(two, up.datagram(2, payload));
  first = Sealer(GetParam(), session_keys.down);
  EXPECT_FALSE(first.seal(DatagramKind::samples, kSession, payload, out).empty());
}

TEST_P(Sealing, AfterTooManyForgeriesNothingIsOpened) {
  constexpr std::uint64_t kLimit = 10;
  Opener opener(GetParam(), session_keys.up, 0, kLimit);
  Octets forged = up.datagram(1, payload);
  forged.back() ^= 1;
  for (std::uint64_t i = 0; i < kLimit; ++i) {
    EXPECT_FALSE(opener.exhausted());
    EXPECT_EQ(read(opener, forged).drop, DropReason::sealed);
  }
  EXPECT_TRUE(opener.exhausted());
  EXPECT_EQ(read(opener, up.datagram(1, payload)).drop, DropReason::sealed);
  EXPECT_EQ(opener.forgeries(), kLimit);
}

TEST_P(Sealing, NeverAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  const std::uint64_t start = kBorder - 2000;
  Sealer sealer = up.sealer_from(start);
  Opener opener = up.opener_from(start);
  DatagramBuffer out, in, spoiled;
  std::uint64_t opened = 0, refused = 0;
  const std::size_t before = test::allocations();
  for (int i = 0; i < 4000; ++i) {  // The numbers cross the border of a generation.
    const Bytes sealed = sealer.seal(DatagramKind::samples, kSession, payload, out);
    std::copy(sealed.begin(), sealed.end(), spoiled.bytes.begin());
    spoiled.bytes[kHeaderSize] ^= 1;
    const Guarded guarded = guard(sealed, kAnyKind);
    const Bytes wrong = Bytes(spoiled.bytes).first(sealed.size());
    refused += opener.open(guarded.header, wrong, in).drop == DropReason::sealed ? 1 : 0;
    opened += opener.open(guarded.header, sealed, in).drop == DropReason::none ? 1 : 0;
    refused += opener.open(guarded.header, sealed, in).drop == DropReason::packet_number ? 1 : 0;
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(opened, 4000u);
  EXPECT_EQ(refused, 8000u);
}

/// Memory that held a key must contain no key afterwards.
TEST_P(Sealing, KeysAreWiped) {
  alignas(Sealer) std::array<std::uint8_t, sizeof(Sealer)> sealer_memory{};
  alignas(Opener) std::array<std::uint8_t, sizeof(Opener)> opener_memory{};
  auto* sealer = new (sealer_memory.data()) Sealer(GetParam(), session_keys.up);
  auto* opener = new (opener_memory.data()) Opener(GetParam(), session_keys.up);
  const auto holds = [](const auto& memory, const Key& key) {
    // The object's lifetime has ended, so the test reads its memory through volatile.
    const volatile std::uint8_t* at = memory.data();
    for (std::size_t i = 0; i + key.size() <= memory.size(); ++i) {
      std::size_t same = 0;
      while (same < key.size() && at[i + same] == key[same]) ++same;
      if (same == key.size()) return true;
    }
    return false;
  };
  // The test searches the memory for the secrets and keys. (With AES, the first round key is half
  // of the key.)
  const std::array<Key, 3> secrets = {session_keys.up, next_secret(session_keys.up),
                                      sealing_key(session_keys.up)};
  EXPECT_TRUE(holds(sealer_memory, secrets[0]));
  EXPECT_TRUE(holds(opener_memory, secrets[1]));
  EXPECT_TRUE(holds(sealer_memory, secrets[2]));
  sealer->~Sealer();
  opener->~Opener();
  for (const Key& secret : secrets) {
    EXPECT_FALSE(holds(sealer_memory, secret));
    EXPECT_FALSE(holds(opener_memory, secret));
  }
}

}  // namespace
}  // namespace feltwire::seal_test
