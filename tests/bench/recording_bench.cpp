// record/FORMAT/HANDS: a second of servo ticks at 1 kHz, from the rings of the hands to files in a
// temporary folder, 20 times a second as in the client. CPU time over a second is the share of a
// core. bytes_per_second is for the file of one hand.

#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/run/recording.hpp"
#include "core/base/splitmix.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::recording_bench {
namespace {

constexpr int kTicks = 1000, kAtOnce = 50;

/// A hand presses and trembles. The last bits of its numbers are noise, as for a real hand.
TickRecord tick(std::int64_t n, std::uint64_t hand) {
  const auto noise = [&](std::uint64_t which) {
    return 1e-6 *
           (static_cast<double>(splitmix::draw(hand, 8 * static_cast<std::uint64_t>(n) + which)) /
                1.8446744073709552e19 -
            0.5);
  };
  const double t = 1e-3 * static_cast<double>(n);
  const double depth = 2e-3 * std::max(0.0, std::sin(6.0 * t)) + noise(0);
  const double force = depth > 0.0 ? 600.0 * depth : 0.0;
  return {.time = t,
          .position = {0.01 * std::cos(t) + noise(1), 0.01 * std::sin(t) + noise(2), -depth},
          .elastic = {0.0, 0.0, force},
          .frictional = {-0.3 * force, 0.0, 0.0},
          .held = {-0.3 * force, 0.0, 0.98 * force},
          .age = 5e-4 + noise(3),
          .clock = 1'000'000 * n,
          .orientation = Quaternion::Identity(),
          .torque = Vec3::Zero(),
          .balance = 1e-4 + noise(4),
          .account_cut = 0.0,
          .no_force = force > 0.0 ? ZeroForceReason::felt : ZeroForceReason::touches_nothing};
}

void record(benchmark::State& state, const std::string& ending) {
  const auto hands = static_cast<std::size_t>(state.range(0));
  const test::TemporaryFolder folder;
  std::vector<std::unique_ptr<Recorder>> recorders;
  std::vector<std::vector<TickRecord>> ticks(hands);
  for (std::size_t hand = 0; hand < hands; ++hand) {
    recorders.push_back(open_recording({.file = folder / (std::to_string(hand) + ending)}));
    for (int n = 0; n < kTicks; ++n) ticks[hand].push_back(tick(n, hand << 32));
  }
  Ring<TickRecord> ring(kAtOnce);
  double seconds = 0.0;
  for (auto _ : state) {
    for (int n = 0; n < kTicks; n += kAtOnce)
      for (std::size_t hand = 0; hand < hands; ++hand) {
        for (int i = 0; i < kAtOnce; ++i) {
          TickRecord row = ticks[hand][static_cast<std::size_t>(n + i)];
          row.time += seconds;
          row.clock += static_cast<std::int64_t>(1e9 * seconds);
          ring.push(row);
        }
        recorders[hand]->write(ring);
      }
    seconds += 1.0;
  }
  recorders[0]->finish();
  const auto bytes = std::filesystem::file_size(folder / ("0" + ending));
  state.counters["bytes_per_second"] = static_cast<double>(bytes) / seconds;
}

const bool kRegistered = [] {
  for (const std::string format : {"csv", "mcap"})
    benchmark::RegisterBenchmark(("record/" + format).c_str(), record, "." + format)
        ->Arg(1)
        ->Arg(16)
        ->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
}  // namespace feltwire::recording_bench
