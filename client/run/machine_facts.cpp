#include "client/run/machine_facts.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <ctime>
#include <fstream>

#include "protocol/net/udp_socket.hpp"

namespace feltwire {
namespace {

std::string first_line(const char* file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

double resolution() {
  constexpr double kNanosecond = 1e-9;
  timespec resolution{};
  if (::clock_getres(CLOCK_MONOTONIC, &resolution) != 0) return 0.0;
  return static_cast<double>(resolution.tv_sec) +
         kNanosecond * static_cast<double>(resolution.tv_nsec);
}

/// Returns the longest wake-up time of the processors that the kernel allows [us]
/// (pm_qos_interface.rst). Reading this file requests no wake-up time; only writing would.
std::optional<int> wake_latency() {
  const int file = ::open("/dev/cpu_dma_latency", O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::int32_t latency = 0;
  const bool whole = ::read(file, &latency, sizeof latency) == sizeof latency;
  ::close(file);
  return whole ? std::optional<int>(latency) : std::nullopt;
}

bool is_ipv6(const Address& server) { return server.storage.ss_family == AF_INET6; }

}  // namespace

MachineFacts machine_facts(const Address& server) {
  return {.clock_source =
              first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
          .clock_resolution = resolution(),
          .wake_latency = wake_latency(),
          .path_mtu = path_mtu(server.storage, server.size),
          .ipv6 = is_ipv6(server)};
}

}  // namespace feltwire
