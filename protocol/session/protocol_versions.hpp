#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace feltwire {

/// The versions of the protocol that a program speaks: all from `oldest` to `newest` (PROTOCOL.md,
/// "Versions"). The default is what this program speaks.
struct ProtocolVersions {
  std::uint16_t newest = 2;
  std::uint16_t oldest = 2;
  bool operator==(const ProtocolVersions&) const = default;
};

/// The version that two programs speak with each other: the newest of both. Empty: there is none.
std::optional<std::uint16_t> common_version(const ProtocolVersions& one,
                                            const ProtocolVersions& other) noexcept;

/// "version 2", "versions 1 to 2"
std::string to_string(const ProtocolVersions& versions);

/// The reason why a server refuses a client that speaks no version of its own, for people.
std::string refused_client(const ProtocolVersions& client, const ProtocolVersions& server);

}  // namespace feltwire
