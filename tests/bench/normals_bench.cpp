// answer/SCENE: the cost of a session's answer to a sample, without a local model. The hand presses
//   and moves at random.
// answer_normals/SCENE: the cost for a client that shapes late forces for each wall. The reply then
//   has the normals of the pressing walls. The difference to answer/SCENE is the server's cost.

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "core/scene_file/load_scene.hpp"
#include "server/scene/session.hpp"

namespace feltwire::normals_bench {
namespace {

constexpr std::size_t kPlaces = 4096;  // number of samples in one lap of the hand

std::vector<Vec3> wandering_hand(const Vec3& start) {
  std::vector<Vec3> places(kPlaces);
  for (std::size_t n = 0; n < kPlaces; ++n) {
    const double t = 2.0 * M_PI * static_cast<double>(n) / kPlaces;
    places[n] = start + Vec3(0.05 * std::sin(3.0 * t), 0.05 * std::cos(2.0 * t),
                             0.004 * std::sin(11.0 * t));
  }
  return places;
}

void answer(benchmark::State& state, const std::string& file, const char* mode) {
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/" + file + ".json");
  SessionParameters parameters;
  parameters.mode = mode;
  parameters.side = BoundingSide::client;
  Session session({"bench", scene.name(), builtin_device("simulated"), parameters}, scene);
  const auto places = wandering_hand(scene.start().position);
  SampleBatch batch;
  batch.count = 1;
  Sample& sample = batch.samples[0];
  std::uint64_t contacts = 0, named = 0;
  for (auto _ : state) {
    sample.pose.position = places[sample.index++ % kPlaces];
    sample.client_time += Nanoseconds(1'000'000);
    const BatchResult taken = session.take(batch, sample.client_time);
    contacts += !taken.reply.command.elastic.isZero(0.0);
    named += taken.reply.normals.count > 0;
  }
  const auto share = [&](std::uint64_t count) {
    return static_cast<double>(count) / static_cast<double>(state.iterations());
  };
  state.counters["contact"] = share(contacts);
  state.counters["named"] = share(named);
}

[[maybe_unused]] const bool registered = [] {
  for (const std::string scene : {"plane", "room", "paper_sphere", "bunny"}) {
    benchmark::RegisterBenchmark(("answer/" + scene).c_str(), answer, scene, "contact_frame");
    benchmark::RegisterBenchmark(("answer_normals/" + scene).c_str(), answer, scene, "shaped");
  }
  return true;
}();

}  // namespace
}  // namespace feltwire::normals_bench
