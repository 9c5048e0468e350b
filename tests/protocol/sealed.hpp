#pragma once
// The seals of both ends for tests: known keys, any packet number, any payload.

#include <optional>
#include <vector>

#include "core/base/splitmix.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/seal.hpp"

namespace feltwire::test {

enum class Way { up, down };  // to the server, to the client

/// Different keys for every session and direction.
inline SessionKeys keys(std::uint64_t session, CipherSuite suite = preferred_suite()) {
  SessionKeys keys{.suite = suite};
  for (std::size_t i = 0; i < kKeySize; ++i) {
    keys.up[i] = static_cast<std::uint8_t>(splitmix::draw(session, i));
    keys.down[i] = static_cast<std::uint8_t>(splitmix::draw(~session, i));
  }
  return keys;
}
inline const Key& secret(const SessionKeys& keys, Way way) {
  return way == Way::up ? keys.up : keys.down;
}

/// The cipher suites of this machine: both, or ChaCha20-Poly1305 alone.
inline std::vector<CipherSuite> suites() {
  std::vector<CipherSuite> all{CipherSuite::chacha20_poly1305};
  if (supported(CipherSuite::aes_256_gcm)) all.push_back(CipherSuite::aes_256_gcm);
  return all;
}

/// Encodes whole datagrams with any packet number of the first generation, even a used one. The
/// bytes live until the next call.
class SealedEncoder {
 public:
  /// Uses the `given` keys for every session, otherwise keys(session).
  explicit SealedEncoder(Way way, const std::optional<SessionKeys>& given = std::nullopt)
      : way_(way), given_(given) {}

  Bytes samples(std::uint64_t session, std::uint64_t number, const SampleBatch& batch) {
    return seal({DatagramKind::samples, session, number}, encoder_.samples(batch));
  }
  Bytes reply(std::uint64_t session, std::uint64_t number, const Reply& reply) {
    return seal({DatagramKind::reply, session, number}, encoder_.reply(reply));
  }
  Bytes goodbye(std::uint64_t session, std::uint64_t number, GoodbyeReason reason) {
    return seal({DatagramKind::goodbye, session, number}, encoder_.goodbye(reason));
  }
  Bytes seal(const Header& header, Bytes payload) {
    const SessionKeys keys = given_ ? *given_ : test::keys(header.session);
    Sealer sealer(keys.suite, secret(keys, way_), header.packet_number - 1);
    return sealer.seal(header.kind, header.session, payload, out_);
  }

 private:
  Way way_;
  std::optional<SessionKeys> given_;
  Encoder encoder_;
  DatagramBuffer out_;
};

/// The payload of a datagram of the first generation, sealed with the `given` keys or
/// keys(session); empty if it cannot be opened.
inline std::vector<std::uint8_t> opened(Bytes datagram, Way way,
                                        const std::optional<SessionKeys>& given = std::nullopt) {
  constexpr unsigned kAnyKind = ~0u;
  const Guarded guarded = guard(datagram, kAnyKind);
  if (guarded.drop != DropReason::none) return {};
  const SessionKeys keys = given ? *given : test::keys(guarded.header.session);
  Opener opener(keys.suite, secret(keys, way));
  DatagramBuffer out;
  const Opened result = opener.open(guarded.header, datagram, out);
  return {result.payload.begin(), result.payload.end()};
}

}  // namespace feltwire::test
