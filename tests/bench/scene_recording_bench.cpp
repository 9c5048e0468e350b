// scene_answer/LOG/SCENE: a second of 16 hands at 1 kHz in one scene, opened, computed and sealed,
//   with an input log (1) or without (0).
// scene_record/SCENE: the recorder's part of such a second.
// scene_replay/SCENE: ten recorded seconds, computed again. `times_real_time` is the speed.
// CPU time over recorded time is the share of a core.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/scene_file/load_scene.hpp"
#include "server/recording/scene_recording.hpp"
#include "server/recording/scene_replay.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::scene_recording_bench {
namespace {

constexpr std::uint64_t kHands = 16;
// ticks of a second, and ticks between two calls of the recorder
constexpr int kTicks = 1000, kBetweenLooks = 10;

std::filesystem::path scene_file(const char* name) {
  return std::filesystem::path(FELTWIRE_SOURCE_DIR) / "scenes" / name;
}

/// A scene with hands that slide and press near its start.
class Hands {
 public:
  Hands(const char* scene_name, EventLog* log)
      : scene(load_scene_and_keep(scene_file(scene_name))),
        sessions_(scene, std::chrono::hours(1), kHands, nullptr, {.sample_rate = 1e6}) {
    sessions_.log_to(log);
    for (std::uint64_t i = 0; i < kHands; ++i)
      sessions_.answer(test::join_request(usual_parameters()), id(i), test::keys(id(i)), now_);
  }

  /// Makes sealed datagrams of `ticks` ticks for answer().
  void prepare(int ticks) {
    datagrams_.clear();
    for (int n = 0; n < ticks; ++n) {
      ++index_;
      for (std::uint64_t i = 0; i < kHands; ++i) {
        SampleBatch batch;
        batch.count = 1;
        batch.previous = index_ - 1;
        batch.samples[0] = test::hand(index_ + 400 * i);
        batch.samples[0].index = index_;
        batch.samples[0].pose.position += scene.start().position;
        const Bytes bytes = encoder_.samples(id(i), index_, batch);
        datagrams_.emplace_back(bytes.begin(), bytes.end());
      }
    }
  }
  /// Calls `look` every ten milliseconds.
  template <class Look>
  void answer(Look look) {
    DatagramBuffer out;
    for (std::size_t i = 0; i < datagrams_.size(); ++i) {
      if (i % kHands == 0) now_ += std::chrono::milliseconds(1);
      benchmark::DoNotOptimize(sessions_.receive(datagrams_[i], {.address = {}, .length = 1},
                                                 now_ + Nanoseconds(1), out));
      if (i % (kHands * kBetweenLooks) == 0) look();
    }
    look();
  }

  Scene scene;

 private:
  static std::uint64_t id(std::uint64_t i) { return (i + 1) << 8; }
  SceneSessions sessions_;
  test::SealedEncoder encoder_{test::Way::up};
  Nanoseconds now_{std::chrono::seconds(1)};
  std::uint64_t index_ = 0;
  std::vector<std::vector<std::uint8_t>> datagrams_;
};

void answer(benchmark::State& state, const char* scene) {
  EventLog log(std::size_t{64} << 20);
  Hands hands(scene, state.range(0) == 0 ? nullptr : &log);
  for (auto _ : state) {
    state.PauseTiming();
    while (log.take()) {
    }
    hands.prepare(kTicks);
    state.ResumeTiming();
    hands.answer([] {});
  }
  if (log.lost() > 0) state.SkipWithError("the log was full");
}

void record(benchmark::State& state, const char* scene) {
  const test::TemporaryFolder folder;
  EventLog log(std::size_t{64} << 20);
  Hands hands(scene, &log);
  SceneRecording recording({.file = folder / "scene.mcap"}, hands.scene.files().get(), 0);
  for (auto _ : state) {
    state.PauseTiming();
    hands.prepare(kTicks);
    hands.answer([] {});
    state.ResumeTiming();
    for (int n = 1; const auto event = log.take(); ++n) {
      recording.add(*event);
      if (n % static_cast<int>(kHands * kBetweenLooks) == 0) recording.flush();
    }
    recording.flush();
  }
  recording.finish();
  state.counters["bytes_per_second"] =
      static_cast<double>(std::filesystem::file_size(folder / "scene.mcap")) /
      static_cast<double>(state.iterations());
}

void replay_all(benchmark::State& state, const char* scene) {
  constexpr int kSeconds = 10;
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "scene.mcap";
  {
    EventLog log(std::size_t{8} << 20);
    Hands hands(scene, &log);
    SceneRecording recording({.file = file}, hands.scene.files().get(), 0);
    for (int second = 0; second < kSeconds; ++second) {
      hands.prepare(kTicks);
      hands.answer([&] {
        while (const auto event = log.take()) recording.add(*event);
      });
    }
    recording.finish();
  }
  double seconds = 0.0;
  for (auto _ : state) {
    const Replay result = replay({file});
    if (!result.bit_equal()) state.SkipWithError("it is not bit-equal");
    seconds += result.time;
  }
  state.counters["times_real_time"] = benchmark::Counter(seconds, benchmark::Counter::kIsRate);
}

const bool kRegistered = [] {
  for (const char* scene : {"room.json", "workshop.json"}) {
    const std::string name = std::string("/") + scene;
    benchmark::RegisterBenchmark(("scene_answer" + name).c_str(), answer, scene)
        ->Arg(0)
        ->Arg(1)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("scene_record" + name).c_str(), record, scene)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("scene_replay" + name).c_str(), replay_all, scene)
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace feltwire::scene_recording_bench
