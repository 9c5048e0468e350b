#pragma once
// The default ports of the programs.

#include <cstdint>

namespace feltwire {

/// The server's control port (tcp). All scenes have udp port kDefaultPort + 1.
/// IANA has assigned none of 6717 to 6766. They lie below the ports that operating systems hand out
/// to outgoing connections (32768 and up), and below those of DDS (7400 + 250 * domain + ...),
/// which ROS 2 uses on the machines that haptic devices are attached to.
inline constexpr std::uint16_t kDefaultPort = 6720;

/// The port of `feltwire-lab link`, which may run beside a server on one machine.
inline constexpr std::uint16_t kDefaultRelayPort = 6740;

}  // namespace feltwire
