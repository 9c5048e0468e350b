#include "protocol/session/protocol_versions.hpp"

#include <algorithm>

namespace feltwire {

std::optional<std::uint16_t> common_version(const ProtocolVersions& one,
                                            const ProtocolVersions& other) noexcept {
  const std::uint16_t newest = std::min(one.newest, other.newest);
  if (newest < std::max(one.oldest, other.oldest)) return std::nullopt;
  return newest;
}

std::string to_string(const ProtocolVersions& versions) {
  if (versions.oldest == versions.newest) return "version " + std::to_string(versions.newest);
  return "versions " + std::to_string(versions.oldest) + " to " + std::to_string(versions.newest);
}

std::string refused_client(const ProtocolVersions& client, const ProtocolVersions& server) {
  const char* older = client.newest < server.oldest ? "client" : "server";
  return "this client speaks " + to_string(client) + " of the feltwire protocol, this server " +
         to_string(server) + "; install a newer " + older;
}

}  // namespace feltwire
