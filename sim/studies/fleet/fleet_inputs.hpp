#pragma once
// The numbers that a simulated fleet rests on, each with its source. An assumption is a number that
// nobody has measured here.

#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/base/splitmix.hpp"

namespace feltwire::fleet {

inline constexpr double kMicroseconds = 1e6;  // in a second

/// Random numbers of a seed, the same on every machine.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : seed_(seed) {}
  std::uint64_t bits() { return splitmix::draw(seed_, drawn_++); }
  /// From 0 to below 1.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Mean 0 and standard deviation 1 (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t seed_, drawn_ = 0;
};

/// A log-normal time, by its median and its 99th percentile.
struct LogNormal {
  double median = 0.0, p99 = 0.0;  // [s]

  double draw(Draws& draws) const {
    constexpr double kNormalP99 = 2.3263478740408408;
    return median * std::exp(draws.normal() * std::log(p99 / median) / kNormalP99);
  }
};

struct FleetInputs {
  std::uint64_t seed = 2;
  std::uint32_t scenes = 10'000;
  // Hands of a scene are uniform between these. Assumption; the mean gives 1 M hands.
  std::uint32_t fewest_hands = 30, most_hands = 170;
  std::uint32_t cores = 64;  // pinned, of a host. Assumption
  // Share of a core. A sealed answer took 5.19 us at saturation: docs/lab/benchmarks.md; 1 kHz.
  double hand_share = 5.19e-3;
  double scene_share = 0.01;  // with no hand. Assumption
  double lost_hosts = 0.05;   // of all, in one rack: the bar of the issue

  // Write of the directory, three servers in memory, measured by a C client on a busy 2-core
  // machine: docs/fleet.md.
  LogNormal write{0.98e-3, 10.5e-3};
  double writes_per_second = 23'600.0;  // the same, asynchronous
  double leader_loss = 6.5;             // [s] the longest of three kills of the leader: 4.5 to 6.5

  double silence = 2.0;                          // [s] silence timeout: docs/limits.md
  double first_wait = 0.25, longest_wait = 4.0;  // [s] between attempts: client/transport
  double attempt = 1.0;                          // [s] time limit of an attempt: client/transport
  double jitter = 0.5;              // of each wait, the share that is random. Not in the client yet
  std::uint32_t most_waiting = 48;  // connections before their token: docs/limits.md
  double join_time = 2e-3;          // [s] of the host's control thread. Assumption
  LogNormal round_trip{20e-3, 100e-3};  // of a client to a host. Assumption
  LogNormal start{0.2, 2.0};            // of a scene, from its files. Assumption
  double probe = 0.25;      // [s] until a standby believes that the owner is silent. Assumption
  double heartbeat = 2.0;   // [s]
  double aged = 15.0;       // [s] without a heartbeat, and a host is taken for dead
  double restart = 20.0;    // [s] of a host. Assumption
  double session = 1800.0;  // [s] mean length, exponential. Assumption
  double partition = 60.0;  // [s]
};

}  // namespace feltwire::fleet
