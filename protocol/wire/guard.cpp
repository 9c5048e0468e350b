#include "protocol/wire/guard.hpp"

#include <algorithm>

#include "core/base/enum_names.hpp"
#include "core/base/little_endian.hpp"

namespace feltwire {
namespace {

// Offsets of the header fields [bytes], as in the table of PROTOCOL.md.
constexpr std::size_t kMagicAt = 0, kVersionAt = 2, kKindAt = 3, kReservedAt = 4, kSessionAt = 8,
                      kPacketNumberAt = 16;

Guarded dropped(DropReason reason) {
  Guarded result;
  result.drop = reason;
  return result;
}

}  // namespace

Guarded guard(Bytes datagram, unsigned expected_kinds) noexcept {
  if (datagram.size() < kMinDatagram || datagram.size() > kMaxDatagram)
    return dropped(DropReason::size);
  const std::uint8_t* bytes = datagram.data();
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes + kMagicAt))
    return dropped(DropReason::magic);
  if (bytes[kVersionAt] != kProtocolVersion) return dropped(DropReason::version);

  const unsigned kind = bytes[kKindAt];
  if (kind < static_cast<unsigned>(DatagramKind::samples) ||
      kind > static_cast<unsigned>(DatagramKind::follower_target) ||
      (expected_kinds >> kind & 1u) == 0)
    return dropped(DropReason::kind);
  if (get_little_endian<std::uint32_t>(bytes + kReservedAt) != 0)
    return dropped(DropReason::reserved);

  Guarded result;
  result.header.kind = static_cast<DatagramKind>(kind);
  result.header.session = get_little_endian<std::uint64_t>(bytes + kSessionAt);
  result.header.packet_number = get_little_endian<std::uint64_t>(bytes + kPacketNumberAt);
  return result;
}

void write_header(std::span<std::uint8_t> datagram, const Header& header) noexcept {
  std::uint8_t* bytes = datagram.data();
  std::copy(kMagic.begin(), kMagic.end(), bytes + kMagicAt);
  bytes[kVersionAt] = kProtocolVersion;
  bytes[kKindAt] = static_cast<std::uint8_t>(header.kind);
  put_little_endian(bytes + kReservedAt, std::uint32_t{0});
  put_little_endian(bytes + kSessionAt, header.session);
  put_little_endian(bytes + kPacketNumberAt, header.packet_number);
}

const char* name(DropReason reason) {
  static constexpr std::array<const char*, kDropReasons> names = {
      "none",   "size", "magic",     "version", "kind",  "reserved",   "session", "packet_number",
      "sealed", "rate", "malformed", "count",   "order", "not_finite", "stale"};
  return enum_name(names, reason);
}

}  // namespace feltwire
