#include "protocol/wire/guard.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "tests/protocol/make.hpp"

namespace feltwire::guard_test {
namespace {

constexpr unsigned kSamplesOnly = 1u << static_cast<unsigned>(DatagramKind::samples);

/// Returns a header as in PROTOCOL.md, followed by room for a tag.
std::vector<std::uint8_t> golden() {
  std::vector<std::uint8_t> datagram = {
      'F',  'W',  1,    1,    0,    0,    0,    0,      // magic, version, kind, reserved
      0x08, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01,   // session 0x0102030405060708
      0xf8, 0xf7, 0xf6, 0xf5, 0xf4, 0xf3, 0xf2, 0xf1};  // packet number 0xf1f2f3f4f5f6f7f8
  datagram.resize(kMinDatagram);
  return datagram;
}

TEST(Guard, HeaderBytesAreTheProtocols) {
  std::vector<std::uint8_t> written(kHeaderSize, 0xaa);
  write_header(written, {DatagramKind::samples, 0x0102030405060708u, 0xf1f2f3f4f5f6f7f8u});
  EXPECT_TRUE(std::equal(written.begin(), written.end(), golden().begin()));

  const Guarded read = guard(golden(), kSamplesOnly);
  ASSERT_EQ(read.drop, DropReason::none);
  EXPECT_EQ(read.header.kind, DatagramKind::samples);
  EXPECT_EQ(read.header.session, 0x0102030405060708u);
  EXPECT_EQ(read.header.packet_number, 0xf1f2f3f4f5f6f7f8u);
}

TEST(Guard, SizeLimits) {
  std::vector<std::uint8_t> datagram = golden();
  datagram.resize(kMaxDatagram);
  EXPECT_EQ(guard(datagram, kSamplesOnly).drop, DropReason::none);
  datagram.resize(kMaxDatagram + 1);
  EXPECT_EQ(guard(datagram, kSamplesOnly).drop, DropReason::size);
  for (std::size_t size = 0; size < kMinDatagram; ++size)
    EXPECT_EQ(guard(Bytes(datagram).first(size), kSamplesOnly).drop, DropReason::size);
  EXPECT_EQ(guard({}, kSamplesOnly).drop, DropReason::size);
}

/// At first every field is wrong. Corrections in the documented order must reveal each next fault.
TEST(Guard, FaultsShowInTheOrderOfTheProtocol) {
  std::vector<std::uint8_t> datagram(kMaxDatagram + 1, 0xff);
  const auto drop = [&] { return guard(datagram, kSamplesOnly).drop; };
  EXPECT_EQ(drop(), DropReason::size);
  datagram.resize(kMinDatagram);
  EXPECT_EQ(drop(), DropReason::magic);
  datagram[0] = 'F';
  EXPECT_EQ(drop(), DropReason::magic);
  datagram[1] = 'W';
  EXPECT_EQ(drop(), DropReason::version);
  datagram[2] = 1;
  EXPECT_EQ(drop(), DropReason::kind);
  datagram[3] = 2;  // A reply is a known kind, but the server does not expect it.
  EXPECT_EQ(drop(), DropReason::kind);
  datagram[3] = 1;
  EXPECT_EQ(drop(), DropReason::reserved);
  for (std::size_t i = 4; i < 8; ++i) {
    EXPECT_EQ(drop(), DropReason::reserved);
    datagram[i] = 0;
  }
  EXPECT_EQ(drop(), DropReason::none);
}

TEST(Guard, EveryKindByteIsJudged) {
  auto datagram = golden();
  for (unsigned kind = 0; kind < 256; ++kind) {
    datagram[3] = static_cast<std::uint8_t>(kind);
    const bool known = kind >= 1 && kind <= 5;
    EXPECT_EQ(guard(datagram, ~0u).drop, known ? DropReason::none : DropReason::kind) << kind;
    EXPECT_EQ(guard(datagram, 0).drop, DropReason::kind) << kind;
  }
}

TEST(DropReasons, EachHasItsOwnName) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kDropReasons; ++i) {
    const std::string own = name(static_cast<DropReason>(i));
    EXPECT_NE(own, "unknown");
    for (const auto& other : names) EXPECT_NE(own, other);
    names.push_back(own);
  }
  EXPECT_STREQ(name(DropReason::count_of_reasons), "unknown");
}

}  // namespace
}  // namespace feltwire::guard_test
