// The keys change as the packet numbers rise. Tests a receiver's reaction to numbers near the
// borders of key generations.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "tests/protocol/make.hpp"
#include "tests/protocol/sealing.hpp"

namespace feltwire::seal_generation_test {
namespace {

using namespace test::sealing;
using test::Generator;

using SealGeneration = test::sealing::Fixture;
INSTANTIATE_TEST_SUITE_P(Suites, SealGeneration, ::testing::ValuesIn(test::suites()),
                         [](const auto& suite) {
                           return suite.param == CipherSuite::aes_256_gcm ? "Aes256Gcm"
                                                                          : "ChaCha20Poly1305";
                         });

/// The numbers cross the border with loss and reordering. The number alone must determine the key.
TEST_P(SealGeneration, TheKeyChangesWithoutAWord) {
  Generator random(1);
  for (int round = 0; round < 10; ++round) {
    Sealer sealer = up.sealer_from(kBorder - 600);
    Opener opener = up.opener_from(kBorder - 600);
    std::vector<Octets> waiting;
    DatagramBuffer out;
    std::uint64_t opened = 0, lost = 0;
    while (sealer.sent() < kBorder + 600) {
      waiting.push_back(octets(sealer.seal(DatagramKind::samples, kSession, payload, out)));
      while (waiting.size() > 100) {
        const auto which = waiting.begin() + static_cast<long>(random() % waiting.size());
        if (random() % 4 == 0)
          ++lost;
        else if (read(opener, *which).drop == DropReason::none)
          ++opened;
        waiting.erase(which);
      }
    }
    EXPECT_EQ(opened + lost + waiting.size(), 1200u);  // No datagram that arrived may be refused.
  }
}

TEST_P(SealGeneration, AFirstDatagramBeyondTheBorderIsEnough) {
  Opener opener = up.opener_from(kBorder - 2);
  EXPECT_EQ(read(opener, up.datagram(kBorder + 3, payload)).payload, payload);
  // Datagrams with lower numbers arrive later. The previous key has sealed them.
  EXPECT_EQ(read(opener, up.datagram(kBorder - 1, payload)).payload, payload);
  EXPECT_EQ(read(opener, up.datagram(kBorder, payload)).payload, payload);
  EXPECT_EQ(read(opener, up.datagram(kBorder - 1, payload)).drop, DropReason::packet_number);
}

TEST_P(SealGeneration, AWrongGenerationIsRefused) {
  // The key of a generation is used with a number of another generation.
  for (const std::uint64_t sealed_in : {0u, 1u, 2u}) {
    for (const std::uint64_t said : {0u, 1u, 2u}) {
      Opener opener = up.opener_from(kBorder + 9);
      const std::uint64_t number = said * kBorder + (said == 0 ? kBorder - 5 : 50);
      const std::uint64_t own = sealed_in * kBorder + 50;
      const AeadKey key(GetParam(), sealing_key(up.secret(sealed_in)));
      Octets datagram(kOverhead + payload.size());
      write_header(datagram, {DatagramKind::samples, kSession, number});
      Nonce nonce{};
      for (std::size_t i = 0; i < 8; ++i)
        nonce[4 + i] = static_cast<std::uint8_t>(number >> (8 * i));
      key.seal(nonce, Bytes(datagram).first(kHeaderSize), payload, datagram.data() + kHeaderSize);
      // The opener began in generation 1, so it never had the key of generation 0.
      const bool good = sealed_in == said && said != 0;
      EXPECT_EQ(read(opener, datagram).drop, good ? DropReason::none : DropReason::sealed)
          << sealed_in << said << own;
    }
  }
  // The number is two generations ahead. A receiver that loses a complete generation does not
  // remain connected.
  Opener opener(GetParam(), session_keys.up);
  EXPECT_EQ(read(opener, up.datagram(2 * kBorder, payload)).drop, DropReason::sealed);
  EXPECT_EQ(opener.forgeries(), 0u);  // The opener must try no key.
}

/// Compares the opener with a simple model. Numbers of all kinds are around the borders of three
/// generations: valid, replayed and forged.
TEST_P(SealGeneration, OpensWhatAModelOpens) {
  Generator random(2);
  for (int round = 0; round < 20; ++round) {
    const std::uint64_t start = kBorder - 1 - random() % 1500;
    Opener opener = up.opener_from(start);
    std::set<std::uint64_t> seen{start};
    std::uint64_t highest = start, forgeries = 0;
    for (int step = 0; step < 400; ++step) {
      std::uint64_t number = highest + 1 + random() % 20;
      const std::uint64_t kind = random() % 100;
      if (kind < 30)
        number = highest - random() % 1500;
      else if (kind < 36)
        number = highest + random() % 3000;
      else if (kind < 39)
        number = highest + kBorder - random() % 2000;
      else if (kind < 41)
        number = highest + 2 * kBorder;
      const bool forged = random() % 5 == 0;
      Octets datagram = up.datagram(number, payload);
      if (forged)
        datagram[kHeaderSize + random() % (datagram.size() - kHeaderSize)] ^=
            static_cast<std::uint8_t>(1u << random() % 8);

      DropReason expected = DropReason::none;
      if (seen.contains(number) || number + PacketWindow::kWidth <= highest)
        expected = DropReason::packet_number;
      else if (forged || generation(number) > generation(highest) + 1)
        expected = DropReason::sealed;
      if (expected == DropReason::sealed && generation(number) <= generation(highest) + 1)
        ++forgeries;
      ASSERT_EQ(read(opener, datagram).drop, expected)
          << "number " << number << " highest " << highest << " start " << start;
      if (expected == DropReason::none) {
        seen.insert(number);
        highest = std::max(highest, number);
      }
      ASSERT_EQ(opener.highest(), highest);
      ASSERT_EQ(opener.forgeries(), forgeries);
    }
  }
}

/// The sender must never use a number twice, so sending ends after the last number.
TEST_P(SealGeneration, AtTheLastNumberTheSenderStops) {
  const Key last_secret = session_keys.up;  // the secret of any generation
  Sealer sealer(GetParam(), last_secret, kLastPacketNumber - 2);
  Opener opener(GetParam(), last_secret, kLastPacketNumber - 2);
  DatagramBuffer out;
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(read(opener, sealer.seal(DatagramKind::samples, kSession, payload, out)).payload,
              payload);
  EXPECT_EQ(opener.highest(), kLastPacketNumber);
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(sealer.seal(DatagramKind::goodbye, kSession, payload, out).empty());
  EXPECT_EQ(sealer.sent(), kLastPacketNumber);
  for (const std::uint64_t number : {std::uint64_t{0}, std::uint64_t{1}, kLastPacketNumber}) {
    Octets wrapped(kMinDatagram);
    write_header(wrapped, {DatagramKind::samples, kSession, number});
    EXPECT_EQ(read(opener, wrapped).drop, DropReason::packet_number);
  }
}

}  // namespace
}  // namespace feltwire::seal_generation_test
