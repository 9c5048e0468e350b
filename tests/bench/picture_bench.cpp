// picture/N: the time of the scene's thread for one picture of the live page. N hands press the
//   room's table.
// picture/modelled/N: the time including the surfaces near the hands, for clients with a local
//   model.
// picture/not_wanted: the time without a viewer.

#include <benchmark/benchmark.h>

#include <string>

#include "core/scene_file/load_scene.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire::picture_bench {
namespace {

const Key kUp = {1}, kDown = {2};

void picture(benchmark::State& state, std::uint64_t hands, bool modelled) {
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json");
  SceneSessions sessions(scene, std::chrono::hours(1), 64);
  Encoder encoder;
  DatagramBuffer sent, answer;
  for (std::uint64_t hand = 1; hand <= hands; ++hand) {
    const std::uint64_t session = hand << 8;
    control::JoinRequest request{"bench", scene.name(), builtin_device("simulated"), {}};
    request.parameters.local_model = modelled;
    sessions.answer(request, session, {preferred_suite(), kUp, kDown}, {});
    Sealer client(preferred_suite(), kUp);
    SampleBatch batch;
    batch.count = 1;
    for (const double z : {0.0, -0.0505}) {
      ++batch.samples[0].index;
      batch.samples[0].pose.position.z() = z;
      sessions.receive(client.seal(DatagramKind::samples, session, encoder.samples(batch), sent),
                       {}, {}, answer);
    }
  }
  Picture drawn;
  for (auto _ : state) {
    sessions.draw(drawn, {});
    benchmark::DoNotOptimize(drawn.hands.data());
  }
  if (drawn.hands.size() != hands || !(drawn.hands[0].depth > 0.0))
    state.SkipWithError("no hand presses");
}

void not_wanted(benchmark::State& state) {
  PictureExchange exchange;
  for (auto _ : state) {
    benchmark::DoNotOptimize(exchange);
    benchmark::DoNotOptimize(exchange.wanted());
  }
}

const bool registered = [] {
  for (const std::uint64_t hands : {1, 16, 64}) {
    const std::string number = std::to_string(hands);
    benchmark::RegisterBenchmark(("picture/" + number).c_str(), picture, hands, false);
    benchmark::RegisterBenchmark(("picture/modelled/" + number).c_str(), picture, hands, true);
  }
  benchmark::RegisterBenchmark("picture/not_wanted", not_wanted);
  return true;
}();

}  // namespace
}  // namespace feltwire::picture_bench
