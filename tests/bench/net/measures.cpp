#include "tests/bench/net/measures.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <thread>

#include "tests/bench/net/viewers.hpp"

namespace feltwire::netbench {
namespace {

constexpr double kHeld = 1e-3;  // share of the answers that may be late
constexpr int kTries = 3;  // tries per step of a search, because these machines sometimes stall
constexpr int kMostSteps = 24;  // number of steps of kClientStep
constexpr int kScalingClients = 64;

Nanoseconds duration(const Settings& settings) {
  return Nanoseconds(std::llround(settings.seconds * 1e9));
}

LoadResult run(const Settings& settings, HostKind kind, int clients) {
  HostOptions host;
  host.kind = kind;
  host.scene_file = settings.scene;
  host.clients = clients == kSaturation ? kSaturatingClients : clients;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  host.suite = settings.suite;
  const HostProcess process(host);
  pin_to(kLoadCore);
  LoadOptions options;
  options.redundancy = settings.redundancy;
  options.suite = settings.suite;
  options.duration = duration(settings);
  options.saturate = clients == kSaturation;
  return Load(process.targets().front(), !ours(kind), options).run(process.process());
}

Figures figures(const std::vector<LoadResult>& runs) {
  const auto over = [&](auto value) {
    std::vector<double> values;
    for (const LoadResult& r : runs) values.push_back(value(r));
    return median(values);
  };
  const auto quantile = [&](double q) {
    return over([q](const LoadResult& r) { return 1e-3 * r.round_trip.quantile(q); });
  };
  Figures f;
  f.cpu = over([](const LoadResult& r) { return r.cpu_per_answer(); });
  f.busy = over([](const LoadResult& r) { return r.server_busy(); });
  f.late = over([](const LoadResult& r) { return r.late_share(); });
  f.with_force = over([](const LoadResult& r) {
    return static_cast<double>(r.with_force) / static_cast<double>(r.answered);
  });
  f.p50 = quantile(0.5);
  f.p99 = quantile(0.99);
  f.p999 = quantile(0.999);
  f.sample_size = runs.front().sample_size;
  f.answer_size = runs.front().answer_size;
  return f;
}

bool holds(const Settings& settings, HostKind kind, int clients) {
  for (int i = 0; i < kTries; ++i)
    if (run(settings, kind, clients).late_share() < kHeld) return true;
  return false;
}

bool holds_between_stalls(const Settings& settings, HostKind kind, int clients) {
  return run(settings, kind, clients).late_share_between_stalls() < kHeld;
}

/// Finds the largest number of clients by bisection, because a server of n clients can also serve
/// fewer.
template <class Holds>
int search(Holds holds_clients) {
  int held = 0, not_held = kMostSteps + 1;
  while (not_held - held > 1) {
    const int middle = (held + not_held) / 2;
    (holds_clients(middle * kClientStep) ? held : not_held) = middle;
  }
  return held * kClientStep;
}

/// Each core runs a scene and its complete load.
double answers_per_second(const Settings& settings, const std::vector<int>& cores) {
  HostOptions host;
  host.scene_file = settings.scene;
  host.clients = kScalingClients;
  host.cores = cores;
  host.redundancy = settings.redundancy;
  host.suite = settings.suite;
  const HostProcess process(host);
  LoadOptions options;
  options.redundancy = settings.redundancy;
  options.suite = settings.suite;
  options.duration = duration(settings);
  options.saturate = options.sleep = true;
  std::vector<LoadResult> results(cores.size());
  std::vector<std::thread> loads;
  for (std::size_t i = 0; i < cores.size(); ++i)
    loads.emplace_back([&, i] {
      pin_to(cores[i]);
      results[i] = Load(process.targets()[i], false, options).run(process.process());
    });
  for (std::thread& load : loads) load.join();
  double sum = 0.0;
  for (const LoadResult& r : results)
    sum += static_cast<double>(r.answered) / std::chrono::duration<double>(r.wall).count();
  return sum;
}

/// A further session has joined but sends nothing. The attacker has the number of this session.
LoadResult run_flooded(const Settings& settings, bool flood) {
  HostOptions host;
  host.scene_file = settings.scene;
  host.clients = kFloodedClients + 1;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  const HostProcess process(host);
  pin_to(kLoadCore);
  LoadOptions options;
  options.redundancy = settings.redundancy;
  options.duration = duration(settings);
  options.flood = flood;
  Target honest = process.targets().front();
  options.known_sessions = {honest.sessions.back()};
  honest.sessions.pop_back();
  return Load(honest, false, options).run(process.process());
}

Flooded flooded(const std::vector<LoadResult>& runs) {
  const Figures f = figures(runs);
  Flooded result{.p50 = f.p50, .p99 = f.p99, .busy = f.busy};
  std::vector<double> lost, garbage;
  for (const LoadResult& r : runs) {
    lost.push_back(1.0 -
                   std::min(1.0, static_cast<double>(r.answered) / static_cast<double>(r.sent)));
    garbage.push_back(static_cast<double>(r.garbage) /
                      std::chrono::duration<double>(r.wall).count());
    result.left_behind = std::max(result.left_behind, r.left_behind);
  }
  result.lost = median(lost);
  result.garbage = median(garbage);
  return result;
}

struct WatchedRun {
  LoadResult load;
  double pictures = 0.0;  // [1/s] pictures of a viewer
};

WatchedRun run_watched(const Settings& settings, bool viewers) {
  HostOptions host;
  host.scene_file = settings.scene;
  host.clients = kWatchedHands;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  host.suite = settings.suite;
  host.page_core = page_core();
  const HostProcess process(host);
  std::optional<Viewers> watching;
  if (viewers)
    watching.emplace(kViewers, process.page_port(), process.viewers_token(), page_core());
  pin_to(kLoadCore);
  LoadOptions options;
  options.redundancy = settings.redundancy;
  options.suite = settings.suite;
  options.duration = duration(settings);
  Load load(process.targets().front(), false, options);
  const std::uint64_t before = viewers ? watching->pictures() : 0;
  const Nanoseconds begin = now();
  WatchedRun result{load.run(process.process())};
  if (viewers)
    result.pictures = static_cast<double>(watching->pictures() - before) / kViewers /
                      std::chrono::duration<double>(now() - begin).count();
  return result;
}

Watched watched(const std::vector<WatchedRun>& runs) {
  std::vector<LoadResult> loads;
  std::vector<double> pictures;
  for (const WatchedRun& r : runs) {
    loads.push_back(r.load);
    pictures.push_back(r.pictures);
  }
  const Figures f = figures(loads);
  return {f.p50, f.p99, f.p999, f.late, median(pictures)};
}

struct RecordedRun {
  LoadResult load;
  Recorded recorded;
};

RecordedRun run_recorded(const Settings& settings, const std::string& file) {
  HostOptions host;
  host.scene_file = settings.scene;
  host.clients = kRecordedHands;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  host.suite = settings.suite;
  host.record = file;
  host.recorder_core = page_core();
  HostProcess process(host);
  pin_to(kLoadCore);
  LoadOptions options;
  options.redundancy = settings.redundancy;
  options.suite = settings.suite;
  constexpr double kLongestAlone = 60.0;  // [s]
  options.duration = duration(settings);
  if (file.empty()) options.duration = std::min(options.duration, from_seconds(kLongestAlone));
  RecordedRun result{Load(process.targets().front(), false, options).run(process.process()), {}};
  if (!file.empty()) result.recorded = process.finish();
  return result;
}

}  // namespace

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

Sweep sweep(const Settings& settings) {
  std::map<int, std::map<HostKind, std::vector<LoadResult>>> runs;
  for (int round = 0; round < settings.rounds; ++round) {
    for (const HostKind kind : kKinds)
      runs[kSaturation][kind].push_back(run(settings, kind, kSaturation));
    for (const int clients : kPacedClients)
      for (const HostKind kind : kKinds)
        runs[clients][kind].push_back(run(settings, kind, clients));
  }
  Sweep result;
  for (const auto& [clients, kinds] : runs)
    for (const auto& [kind, results] : kinds) result[clients][kind] = figures(results);
  return result;
}

std::map<HostKind, ClientsHeld> clients_held(const Settings& settings) {
  std::map<HostKind, std::vector<double>> altogether, between_stalls;
  for (int round = 0; round < settings.rounds; ++round)
    for (const HostKind kind : kHoldingKinds) {
      altogether[kind].push_back(
          search([&](int clients) { return holds(settings, kind, clients); }));
      between_stalls[kind].push_back(
          search([&](int clients) { return holds_between_stalls(settings, kind, clients); }));
    }
  std::map<HostKind, ClientsHeld> result;
  for (const HostKind kind : kHoldingKinds)
    result[kind] = {static_cast<int>(median(altogether[kind])),
                    static_cast<int>(median(between_stalls[kind]))};
  return result;
}

std::vector<Scaling> scaling(const Settings& settings) {
  std::vector<int> counts;
  for (int n = 1; n <= cores(); n *= 2) counts.push_back(n);
  std::vector<std::vector<double>> answers(counts.size());
  for (int round = 0; round < settings.rounds; ++round) {
    const double first = answers_per_second(settings, {kServerCore});
    for (std::size_t i = 1; i < counts.size(); ++i) {
      std::vector<int> used(static_cast<std::size_t>(counts[i]));
      std::iota(used.begin(), used.end(), 0);
      answers[i].push_back(answers_per_second(settings, used));
    }
    answers[0].push_back(0.5 * (first + answers_per_second(settings, {kLoadCore})));
  }
  std::vector<Scaling> result;
  for (std::size_t i = 0; i < counts.size(); ++i)
    result.push_back({counts[i], 1e-6 * median(answers[i])});
  return result;
}

int page_core() { return cores() > 2 ? 2 : kServerCore; }

ViewingFigures viewing(const Settings& settings) {
  std::vector<WatchedRun> alone, beside;
  std::vector<double> ratios;
  for (int round = 0; round < settings.rounds; ++round) {
    const bool viewers_first = round % 2 == 1;
    for (const bool viewers : {viewers_first, !viewers_first})
      (viewers ? beside : alone).push_back(run_watched(settings, viewers));
    ratios.push_back(static_cast<double>(beside.back().load.round_trip.quantile(0.99)) /
                     static_cast<double>(alone.back().load.round_trip.quantile(0.99)));
  }
  return {watched(alone), watched(beside), median(ratios)};
}

RecordingFigures recording(const Settings& settings, const std::string& file) {
  std::vector<double> alone, beside, cost, late_alone, late_beside, answers, bytes;
  RecordingFigures result;
  for (int round = 0; round < settings.rounds; ++round) {
    const LoadResult without = run_recorded(settings, "").load;
    const auto [with, recorded] = run_recorded(settings, file);
    const double time = std::chrono::duration<double>(with.wall).count();
    alone.push_back(without.server_busy());
    beside.push_back(with.server_busy());
    cost.push_back(beside.back() - alone.back());
    late_alone.push_back(without.late_share());
    late_beside.push_back(with.late_share());
    answers.push_back(static_cast<double>(with.answered) / time);
    bytes.push_back(static_cast<double>(recorded.bytes) / time);
    result.lost = std::max(result.lost, recorded.lost);
  }
  result.alone = median(alone);
  result.recording = median(beside);
  result.cost = median(cost);
  result.late_alone = median(late_alone);
  result.late_recording = median(late_beside);
  result.answers = median(answers);
  result.bytes = median(bytes);
  return result;
}

FloodFigures flood(const Settings& settings) {
  std::vector<LoadResult> alone, beside_flood;
  for (int round = 0; round < settings.rounds; ++round) {
    alone.push_back(run_flooded(settings, false));
    beside_flood.push_back(run_flooded(settings, true));
  }
  return {flooded(alone), flooded(beside_flood)};
}

}  // namespace feltwire::netbench
