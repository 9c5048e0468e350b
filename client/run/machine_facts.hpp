#pragma once
// The properties of this machine and of its network path that limit a servo loop.

#include <optional>
#include <string>

#include "client/transport/control_client.hpp"

namespace feltwire {

struct MachineFacts {
  std::string clock_source;         // of the kernel, "tsc"; empty: not known
  double clock_resolution = 0.0;    // [s] of the monotonic clock
  std::optional<int> wake_latency;  // [us] that processors may take to wake; not known without
                                    // permission to read it
  std::optional<int> path_mtu;      // [bytes] of a packet to the server, headers included
  bool ipv6 = false;                // to the server
};

/// Asks the system. It cannot fail: a missing answer is not known. `server`: of the datagrams.
MachineFacts machine_facts(const Address& server);

}  // namespace feltwire
