// touch/SCENE: a scene's answer to a tool that moves at random.
// local_model/SCENE: the answer plus the surfaces near the tool. The difference to touch/SCENE is
//   the cost of these surfaces in a reply.
// local_contact/SCENE: a client's contact with these surfaces, with a model every 20 ticks.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"

namespace feltwire::touch_bench {
namespace {

Scene scene_of(const std::string& file) {
  return load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/" + file + ".json");
}

constexpr std::size_t kPlaces = 4096;  // a lap of the hand, made before the clock runs

std::array<Tool, kPlaces> hand_in(const Scene& scene) {
  std::array<Tool, kPlaces> hand;
  for (std::size_t n = 0; n < kPlaces; ++n) {
    const double t = 2.0 * M_PI * static_cast<double>(n) / kPlaces;
    hand[n].position =
        scene.start().position +
        Vec3(0.05 * std::sin(3.0 * t), 0.05 * std::cos(2.0 * t), 0.004 * std::sin(11.0 * t));
    hand[n].velocity = {0.05, 0.02, -0.01};
  }
  return hand;
}

/// Calls call(scene, tool, memory) for each position of the hand in turn.
template <class Call>
void lap(benchmark::State& state, const std::string& file, const Call& call) {
  const Scene scene = scene_of(file);
  TouchMemory memory = scene.memory();
  const auto hand = hand_in(scene);
  std::size_t n = 0;
  for (auto _ : state) {
    call(scene, hand[n], memory);
    n = (n + 1) % kPlaces;
  }
}

void touch(benchmark::State& state, const std::string& file) {
  lap(state, file, [](const Scene& scene, const Tool& tool, TouchMemory& memory) {
    benchmark::DoNotOptimize(scene.touch(tool, memory));
  });
}

void model(benchmark::State& state, const std::string& file) {
  lap(state, file, [](const Scene& scene, const Tool& tool, TouchMemory& memory) {
    benchmark::DoNotOptimize(scene.touch(tool, memory));
    benchmark::DoNotOptimize(local_model(scene, tool.position, memory));
  });
}

void contact(benchmark::State& state, const std::string& file) {
  constexpr std::size_t kInterval = 20;  // ticks
  const Scene scene = scene_of(file);
  TouchMemory memory = scene.memory();
  const auto hand = hand_in(scene);
  std::vector<LocalModel> models;
  for (std::size_t n = 0; n < kPlaces; n += kInterval) {
    scene.touch(hand[n], memory);
    models.push_back(local_model(scene, hand[n].position, memory));
  }
  LocalContact local;
  std::size_t n = 0;
  for (auto _ : state) {
    if (n % kInterval == 0) local.take(models[n / kInterval]);
    benchmark::DoNotOptimize(local.touch(hand[n], 0.01, 1e-3));
    n = (n + 1) % kPlaces;
  }
}

[[maybe_unused]] const bool registered = [] {
  for (const std::string scene : {"room", "paper_sphere", "plane"}) {
    benchmark::RegisterBenchmark(("touch/" + scene).c_str(), touch, scene);
    benchmark::RegisterBenchmark(("local_model/" + scene).c_str(), model, scene);
    benchmark::RegisterBenchmark(("local_contact/" + scene).c_str(), contact, scene);
  }
  return true;
}();

}  // namespace
}  // namespace feltwire::touch_bench
