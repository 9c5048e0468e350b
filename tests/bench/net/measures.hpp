#pragma once
// The measurements of a server and of echoes for comparison, in alternating runs.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/net/load.hpp"

namespace feltwire::netbench {

struct Settings {
  std::string scene;
  int rounds = 5;        // alternating runs of everything
  double seconds = 1.0;  // counted time of a run
  int redundancy = 0;
  CipherSuite suite = preferred_suite();
};

inline constexpr std::array kKinds = {HostKind::echo_blocking, HostKind::echo_waiting,
                                      HostKind::echo_spinning, HostKind::ours_sleeping,
                                      HostKind::ours_bounded,  HostKind::ours_spinning};
inline constexpr int kServerCore = 0, kLoadCore = 1;

/// Whether it keeps its core busy all the time.
constexpr bool spins(HostKind kind) {
  return kind == HostKind::echo_spinning || kind == HostKind::ours_spinning;
}

/// Medians over the rounds.
struct Figures {
  double cpu = 0.0;                         // [ns] of the server per answer
  double busy = 0.0;                        // share of the server's core
  double p50 = 0.0, p99 = 0.0, p999 = 0.0;  // [us] of the round trip
  double late = 0.0, with_force = 0.0;      // shares
  std::size_t sample_size = 0, answer_size = 0;
};

/// By number of clients (0: saturation), then by kind.
using Sweep = std::map<int, std::map<HostKind, Figures>>;
inline constexpr int kSaturation = 0;
inline constexpr int kSaturatingClients = 250;
inline constexpr std::array kPacedClients = {1, 10, 50, 250};
Sweep sweep(const Settings& settings);

/// The largest number of clients at 1 kHz, in steps, with less than 0.1 % of the answers late.
/// Medians over the rounds; each round has its own search.
struct ClientsHeld {
  int altogether = 0;      // in the best of a few runs
  int between_stalls = 0;  // in the median window of 20 ms: without the machine's stalls
};
inline constexpr int kClientStep = 25;
inline constexpr std::array kHoldingKinds = {HostKind::echo_blocking, HostKind::echo_waiting,
                                             HostKind::echo_spinning, HostKind::ours_sleeping,
                                             HostKind::ours_spinning, HostKind::ours_real_time};
std::map<HostKind, ClientsHeld> clients_held(const Settings& settings);

/// Answers a second, in millions, for as many scenes as cores. Each scene shares its core with its
/// load. Measured on one core, on two, and on each power of two up to all cores.
struct Scaling {
  int cores = 1;
  double answers = 0.0;  // [millions/s] of all scenes together
};
std::vector<Scaling> scaling(const Settings& settings);

/// Honest clients at 1 kHz, alone and beside a flood of garbage. Medians over the rounds; the
/// maximum of `left_behind`.
struct Flooded {
  double p50 = 0.0, p99 = 0.0;  // [us] of the round trip
  double lost = 0.0;            // share of the samples without an answer
  double garbage = 0.0;         // [1/s]
  double busy = 0.0;            // share of the server's core
  int left_behind = 0;          // clients without answers at the end
};
inline constexpr int kFloodedClients = 20;
struct FloodFigures {
  Flooded alone, beside_flood;
};
FloodFigures flood(const Settings& settings);

/// Hands at 1 kHz, alone and beside viewers of the live page. Ratios, and medians over the rounds.
struct Watched {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0;  // [us] of the round trip
  double late = 0.0;                        // share
  double pictures = 0.0;                    // [1/s] that a viewer received
};
inline constexpr int kWatchedHands = 16, kViewers = 5;
struct ViewingFigures {
  Watched alone, beside_viewers;
  double p99_ratio = 0.0;  // the median over the rounds of each pair's ratio
};
ViewingFigures viewing(const Settings& settings);
/// The page's core: its own if there is one, otherwise the server's; the viewers share it.
int page_core();

/// Hands at 1 kHz, without and with a recording. Medians over the rounds; the maximum of `lost`.
struct RecordingFigures {
  double alone = 0.0, recording = 0.0;  // share of a core that all the server's threads used
  double cost = 0.0;                    // the median of each pair's difference
  double late_alone = 0.0, late_recording = 0.0;  // share of the answers after more than 1 ms
  double answers = 0.0;                           // [1/s] during the recording
  double bytes = 0.0;                             // [1/s] of the file
  std::uint64_t lost = 0;                         // events
};
inline constexpr int kRecordedHands = 16;
/// The newest recording stays at `file`. The runs without a recording take a minute at most.
RecordingFigures recording(const Settings& settings, const std::string& file);

/// Our client's servo at 1 kHz, on the load's core.
struct ServoFigures {
  std::string how;
  double late_p50 = 0.0, late_p99 = 0.0;  // [us] behind the deadline
  double round_trip_p50 = 0.0, round_trip_p99 = 0.0, round_trip_p999 = 0.0;  // [us]
};
inline constexpr std::size_t kServoOurs = 1, kServoRealTime = 2;  // places in the result of servo()
std::vector<ServoFigures> servo(const Settings& settings);

double median(std::vector<double> values);

}  // namespace feltwire::netbench
