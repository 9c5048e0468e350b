#pragma once
// The default ports of the programs, and how a port is written.

#include <cstdint>
#include <string>

namespace feltwire {

/// The server's control port (tcp). All scenes have udp port kDefaultPort + 1.
/// IANA has assigned none of 6717 to 6766. They lie below the ports that operating systems hand out
/// to outgoing connections (32768 and up), and below those of DDS (7400 + 250 * domain + ...),
/// which ROS 2 uses on the machines that haptic devices are attached to.
inline constexpr std::uint16_t kDefaultPort = 6720;

/// The port of `feltwire-lab link`, which may run beside a server on one machine.
inline constexpr std::uint16_t kDefaultRelayPort = 6740;

/// HOST:PORT, an IPv6 address in brackets: "[::1]:6720".
inline std::string host_and_port(const std::string& host, std::uint16_t port) {
  const bool v6 = host.find(':') != std::string::npos;
  return (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace feltwire
