#pragma once
// Many clients in one thread: real datagrams of the protocol, one socket.

#include <memory>
#include <vector>

#include "core/base/histogram.hpp"
#include "tests/bench/net/host.hpp"
#include "tests/bench/net/machine.hpp"

namespace feltwire::netbench {

struct LoadOptions {
  int redundancy = 0;
  CipherSuite suite = preferred_suite();
  Nanoseconds period = std::chrono::milliseconds(1);  // of each client
  Nanoseconds warm_up = std::chrono::milliseconds(200);
  Nanoseconds duration = std::chrono::seconds(1);
  bool saturate = false;                      // each client sends again as soon as it has an answer
  bool flood = false;                         // garbage in all the remaining time (paced)
  std::vector<std::uint64_t> known_sessions;  // for the flood's sender
  bool sleep = false;  // between answers (saturate): for a load that shares the server's core
};

/// The result of the counted part of a run.
struct LoadResult {
  std::uint64_t sent = 0, answered = 0, late = 0;  // late: after more than 1 ms
  std::uint64_t with_force = 0;                    // answers with a force
  std::uint64_t bad = 0;                           // datagrams that are not answers
  std::uint64_t garbage = 0;                       // datagrams of the flood
  int left_behind = 0;                             // clients without an answer for some time
  Nanoseconds server_cpu{0}, wall{0};
  Nanoseconds longest_pause{0};  // of the load's own thread
  struct Window {
    std::uint64_t answered = 0, late = 0;
  };
  static constexpr Nanoseconds kWindow = std::chrono::milliseconds(20);
  std::vector<Window> windows;  // by arrival time
  Histogram round_trip;         // [ns] from before the sending call to after the receiving one
  std::size_t sample_size = 0, answer_size = 0;  // [bytes] of a datagram

  double cpu_per_answer() const { return nanoseconds(server_cpu) / static_cast<double>(answered); }
  double server_busy() const { return nanoseconds(server_cpu) / nanoseconds(wall); }
  /// The late share of the sent samples; lost samples count as late.
  double late_share() const {
    const std::uint64_t in_time = answered - std::min(late, answered);
    return 1.0 - std::min(1.0, static_cast<double>(in_time) / static_cast<double>(sent));
  }
  /// The late share in the median window: without other work on the server's or the load's core.
  double late_share_between_stalls() const;

 private:
  static double nanoseconds(Nanoseconds time) { return static_cast<double>(time.count()); }
};

/// Plays the clients of one target. The constructor allocates all memory.
class Load {
 public:
  Load(const Target& target, bool echoed, const LoadOptions& options);
  ~Load();
  /// Runs in the calling thread, which should have its own core. Measures the CPU time of `host`.
  LoadResult run(pid_t host);

 private:
  struct Clients;
  std::unique_ptr<Clients> clients_;
};

}  // namespace feltwire::netbench
