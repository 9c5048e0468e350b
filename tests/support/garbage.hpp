#pragma once
// The datagrams of an attacker at a scene's port.

#include <cstdint>
#include <vector>

#include "core/base/splitmix.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"

namespace feltwire::test {

/// Datagrams of four kinds in turn: random bytes; a valid header of an unknown session; the number
/// of an overheard session with a payload that the attacker cannot seal; and such a datagram cut
/// short. Equal arguments give equal bytes.
class Garbage {
 public:
  explicit Garbage(std::vector<std::uint64_t> known_sessions)
      : sessions_(std::move(known_sessions)) {}

  std::vector<std::uint8_t> next() {
    switch (made_++ % 4) {
      case 0:
        return noise();
      case 1:
        return headed(draw() | 1u);
      case 2:
        return headed(known());
      default:
        return cut();
    }
  }

 private:
  static constexpr std::size_t kSize = 112;  // [bytes] like an honest sample
  static constexpr std::uint64_t kSeed = 11, kIndices = 1024;

  std::uint64_t draw() { return splitmix::draw(kSeed, draws_++); }
  std::uint64_t known() {
    return sessions_.empty() ? draw() : sessions_[draw() % sessions_.size()];
  }

  std::vector<std::uint8_t> noise() {
    std::vector<std::uint8_t> bytes(kSize);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw());
    return bytes;
  }
  std::vector<std::uint8_t> headed(std::uint64_t session) {
    auto bytes = noise();
    write_header(bytes, {DatagramKind::samples, session, draw()});
    return bytes;
  }
  std::vector<std::uint8_t> cut() {
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0].index = 1 + draw() % kIndices;
    auto bytes = headed(known());
    bytes.resize(kHeaderSize);
    const Bytes payload = encoder_.samples(batch);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    bytes.resize(draw() % bytes.size());
    return bytes;
  }

  std::vector<std::uint64_t> sessions_;
  Encoder encoder_;
  std::uint64_t draws_ = 0, made_ = 0;
};

}  // namespace feltwire::test
