#pragma once
// Shared by the tests of sealed datagrams.

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "tests/protocol/sealed.hpp"

namespace feltwire::test::sealing {

using Octets = std::vector<std::uint8_t>;

inline constexpr std::uint64_t kSession = 0x0102030405060708;
inline constexpr std::uint64_t kBorder = std::uint64_t{1} << kGenerationBits;
inline constexpr unsigned kAnyKind = ~0u;

inline Octets octets(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// Reads a datagram as both programs do, and copies the payload.
struct Read {
  DropReason drop;
  Octets payload;
};
inline Read read(Opener& opener, Bytes datagram) {
  const Guarded guarded = guard(datagram, kAnyKind);
  if (guarded.drop != DropReason::none) return {guarded.drop, {}};
  DatagramBuffer out;
  const Opened opened = opener.open(guarded.header, datagram, out);
  return {opened.drop, octets(opened.payload)};
}

/// A direction with a known secret: it makes datagrams with any number.
class Direction {
 public:
  Direction(CipherSuite suite, const Key& secret) : suite_(suite), secrets_{secret} {}

  Octets datagram(std::uint64_t number, Bytes payload, std::uint64_t session = kSession) {
    Sealer sealer(suite_, secret(generation(number - 1)), number - 1);
    return octets(sealer.seal(DatagramKind::samples, session, payload, out_));
  }
  const Key& secret(std::uint64_t which) {
    while (secrets_.size() <= which) secrets_.push_back(next_secret(secrets_.back()));
    return secrets_[which];
  }
  Sealer sealer_from(std::uint64_t sent) { return {suite_, secret(generation(sent)), sent}; }
  Opener opener_from(std::uint64_t highest) {
    return {suite_, secret(generation(highest)), highest};
  }

 private:
  CipherSuite suite_;
  std::vector<Key> secrets_;
  DatagramBuffer out_;
};

/// A test for every cipher suite: a session's keys, and its direction up.
class Fixture : public ::testing::TestWithParam<CipherSuite> {
 protected:
  SessionKeys session_keys = keys(kSession, GetParam());
  Direction up{GetParam(), session_keys.up};
  Octets payload = octets(Bytes(session_keys.down).first(24));  // arbitrary bytes
};

}  // namespace feltwire::test::sealing
