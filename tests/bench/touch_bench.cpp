// touch/SCENE: what a scene answers a tool that wanders through it.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>

#include "core/scene/scene.hpp"

namespace feltwire {
namespace {

void touch(benchmark::State& state, const std::string& file) {
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/" + file + ".json");
  TouchMemory memory = scene.memory();
  constexpr std::size_t kPlaces = 4096;  // a lap of the hand, made before the clock runs
  std::array<Tool, kPlaces> hand;
  for (std::size_t n = 0; n < kPlaces; ++n) {
    const double t = 2.0 * M_PI * static_cast<double>(n) / kPlaces;
    hand[n].position =
        scene.start().position +
        Vec3(0.05 * std::sin(3.0 * t), 0.05 * std::cos(2.0 * t), 0.004 * std::sin(11.0 * t));
    hand[n].velocity = {0.05, 0.02, -0.01};
  }
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(scene.touch(hand[n], memory));
    n = (n + 1) % kPlaces;
  }
}

[[maybe_unused]] const bool registered = [] {
  for (const char* scene : {"room", "paper_sphere", "plane"})
    benchmark::RegisterBenchmark((std::string("touch/") + scene).c_str(), touch,
                                 std::string(scene));
  return true;
}();

}  // namespace
}  // namespace feltwire
