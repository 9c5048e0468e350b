#include "protocol/wire/seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "core/base/little_endian.hpp"
#include "protocol/crypto/hkdf.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kNumberAt = 4;  // [bytes] offset of the packet number in the nonce

Nonce nonce_of(std::uint64_t packet_number) noexcept {
  Nonce nonce{};
  put_little_endian(nonce.data() + kNumberAt, packet_number);
  return nonce;
}

Key expand(const Key& secret, std::string_view purpose) noexcept {
  Key key;
  hkdf_expand(secret, purpose, key);
  return key;
}

void wipe(Key& key) noexcept { ::sodium_memzero(key.data(), key.size()); }

AeadKey ready_key(CipherSuite suite, const Key& secret) {
  Key key = sealing_key(secret);
  const AeadKey ready(suite, key);
  wipe(key);
  return ready;
}

}  // namespace

Key next_secret(const Key& secret) noexcept { return expand(secret, "feltwire key update"); }
Key sealing_key(const Key& secret) noexcept { return expand(secret, "feltwire key"); }

Sealer::Sealer(CipherSuite suite, const Key& secret, std::uint64_t sent)
    : suite_(suite), secret_(secret), key_(ready_key(suite, secret)), sent_(sent) {}

Sealer::~Sealer() { wipe(secret_); }

Sealer::Sealer(Sealer&& other) noexcept
    : suite_(other.suite_),
      secret_(other.secret_),
      key_(other.key_),
      sent_(std::exchange(other.sent_, kLastPacketNumber)) {}

Sealer& Sealer::operator=(Sealer&& other) noexcept {
  suite_ = other.suite_;
  secret_ = other.secret_;
  key_ = other.key_;
  sent_ = std::exchange(other.sent_, kLastPacketNumber);
  return *this;
}

Bytes Sealer::seal(DatagramKind kind, std::uint64_t session, Bytes payload,
                   DatagramBuffer& out) noexcept {
  if (payload.size() > kMaxPayload || sent_ == kLastPacketNumber) return {};
  const std::uint64_t number = sent_ + 1;
  if (generation(number) != generation(sent_)) {
    secret_ = next_secret(secret_);
    key_ = ready_key(suite_, secret_);
  }
  sent_ = number;
  write_header(out.bytes, {kind, session, number});
  const Bytes bytes(out.bytes);
  key_.seal(nonce_of(number), bytes.first(kHeaderSize), payload, out.bytes.data() + kHeaderSize);
  return bytes.first(kHeaderSize + payload.size() + kTagSize);
}

Opener::Opener(CipherSuite suite, const Key& secret, std::uint64_t highest, std::uint64_t forgeries)
    : suite_(suite),
      secret_(next_secret(secret)),
      current_(ready_key(suite, secret)),
      next_(ready_key(suite, secret_)),
      window_(highest),
      generation_(generation(highest)),
      forgery_limit_(std::min(forgeries, forgery_limit(suite))) {}

Opener::~Opener() { wipe(secret_); }

/// Returns the key for the generation of this packet number, or null. The key of the next
/// generation is derived in advance. Otherwise forged numbers would make this machine derive keys,
/// and an attacker could measure the time (RFC 9001, 9.5).
const AeadKey* Opener::key_of(std::uint64_t packet_number) const noexcept {
  const std::uint64_t wanted = generation(packet_number);
  if (wanted == generation_) return &current_;
  if (wanted == generation_ + 1) return &next_;
  if (wanted + 1 == generation_ && previous_) return &*previous_;
  return nullptr;
}

Opened Opener::open(const Header& header, Bytes datagram, DatagramBuffer& out) noexcept {
  if (!window_.fresh(header.packet_number)) return {DropReason::packet_number, {}};
  const AeadKey* key = key_of(header.packet_number);
  if (key == nullptr || exhausted()) return {DropReason::sealed, {}};
  if (!key->open(nonce_of(header.packet_number), datagram.first(kHeaderSize),
                 datagram.subspan(kHeaderSize), out.bytes.data())) {
    ++forgeries_;
    return {DropReason::sealed, {}};
  }
  window_.mark(header.packet_number);
  advance_to(header.packet_number);
  return {DropReason::none, Bytes(out.bytes).first(datagram.size() - kOverhead)};
}

void Opener::advance_to(std::uint64_t packet_number) noexcept {
  if (generation(packet_number) == generation_ + 1) {
    previous_ = current_;
    current_ = next_;
    secret_ = next_secret(secret_);
    next_ = ready_key(suite_, secret_);
    ++generation_;
  }
  // Wipe the previous key when the packet window contains no number of its generation. Then an
  // attacker who obtains the keys later cannot open the old datagrams.
  constexpr std::uint64_t kWithin = (std::uint64_t{1} << kGenerationBits) - 1;
  if (previous_ && (highest() & kWithin) + 1 >= PacketWindow::kWidth) previous_.reset();
}

Received receive(Bytes datagram, unsigned expected_kinds, std::uint64_t session, Opener& opener,
                 DatagramBuffer& out) noexcept {
  const Guarded guarded = guard(datagram, expected_kinds);
  if (guarded.drop != DropReason::none) return {.drop = guarded.drop, .payload = {}};
  if (guarded.header.session != session) return {.drop = DropReason::session, .payload = {}};
  const Opened opened = opener.open(guarded.header, datagram, out);
  return {opened.drop, guarded.header.kind, opened.payload};
}

}  // namespace feltwire
