// world_step/CASE/N: a tick of N free boxes of 4 cm and 100 g. `apart`: in the air without gravity;
//   `table`: at rest on a table; `piles`: in piles of five on a table.
// world_touch/N: the answer of a scene of N moving boxes to a tool that moves over them at random.
// world_push/N: the extra cost of a tick for a hand without a new sample.
// moving/LAYOUT/SHAPE/N: a sample of a hand that strokes one of N moving objects, without a tick.
//   `crowd`: side by side; `far`: a metre apart. The objects are boxes or meshes.
// moving/load/N: the time from objects and bodies to a world.

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "core/dynamics/mujoco_compile.hpp"
#include "core/dynamics/world.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"

namespace feltwire::world_bench {
namespace {

constexpr double kHalf = 0.02, kPitch = 0.06;  // [m]
constexpr int kRow = 10, kPile = 5;

enum class Layout { apart, table, piles };

Vec3 place_of(int box, Layout layout) {
  const int column = layout == Layout::piles ? box / kPile : box;
  const int storey = layout == Layout::piles ? box % kPile : 0;
  const double height = layout == Layout::apart ? 0.1 : kHalf * (1 + 2 * storey);
  return {kPitch * (column % kRow), kPitch * (column / kRow), height};
}

Scene boxes(int count, Layout layout, const Shape& shape = Box{Vec3::Constant(kHalf)},
            double apart = 1.0) {
  const Material wood{.stiffness = 900, .static_friction = 0.6, .dynamic_friction = 0.5};
  std::vector<Object> objects(1);
  objects[0].name = "table";
  objects[0].shape = Plane{};
  objects[0].material = wood;
  std::vector<int> body_of{-1};
  std::vector<Body> bodies;
  for (int i = 0; i < count; ++i) {
    Object box;
    box.name = "box " + std::to_string(i);
    box.shape = shape;
    box.material = wood;
    box.pose.position = apart * place_of(i, layout);
    Body body;
    body.name = box.name;
    body.mass = 0.1;
    body.pose = box.pose;
    body_of.push_back(i);
    bodies.push_back(body);
    objects.push_back(box);
  }
  MechanismOptions options;
  if (layout == Layout::apart) options.gravity.setZero();
  const auto mechanism = compile(objects, body_of, bodies, options);
  Scene scene("boxes", objects);
  scene.set_mechanism(mechanism);
  return scene;
}

void step(benchmark::State& state, int count, Layout layout) {
  constexpr int kSettle = 1000;
  const Scene scene = boxes(count, layout);
  World world(scene);
  for (int i = 0; i < kSettle; ++i) world.step();
  for (auto _ : state) benchmark::DoNotOptimize(world.step());
  if (world.counters().resets > 0) state.SkipWithError("the simulation broke");
}

Vec3 wandering(std::size_t n) {
  const double t = 1e-3 * static_cast<double>(n % 10000);
  return {0.27 * (1 + std::sin(3 * t)), 0.27 * (1 + std::sin(2 * t)),
          kHalf * (1.5 + std::sin(11 * t))};
}

void touch(benchmark::State& state, int count) {
  const Scene scene = boxes(count, Layout::table);
  World world(scene);
  TouchMemory memory = scene.memory();
  BodyContactState contacts = world.contact_state();
  std::size_t n = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(world.touch({wandering(n++), Vec3::Zero()}, memory, contacts));
}

/// Returns a box of 1200 triangles.
Shape mesh() {
  constexpr int kSquares = 10;
  return Mesh{std::make_shared<const MeshSurface>(
      TriangleMesh(tessellate(Box{Vec3::Constant(kHalf)}, kSquares)))};
}

void stroke(benchmark::State& state, int count, const Shape& shape, double apart) {
  const Scene scene = boxes(count, Layout::apart, shape, apart);
  World world(scene);
  TouchMemory memory = scene.memory();
  BodyContactState contacts = world.contact_state();
  const auto middle = static_cast<std::size_t>(count / 2);
  const Vec3 at = world.objects()[1 + middle].pose.position + Vec3(0, 0, kHalf - 1e-3);
  std::size_t n = 0;
  double felt = 0.0;
  for (auto _ : state) {
    const double t = 1e-3 * static_cast<double>(n++ % 10000);
    const Vec3 place = at + Vec3(0.01 * std::sin(3 * t), 0.01 * std::sin(2 * t), 0.0);
    felt += world.touch({place, Vec3::Zero()}, memory, contacts).elastic.z();
  }
  if (!(felt > 0.0)) state.SkipWithError("nothing was touched");
}

void load(benchmark::State& state, int count) {
  for (auto _ : state) {
    const Scene scene = boxes(count, Layout::apart);
    const World world(scene);
    benchmark::DoNotOptimize(&world.objects());
  }
}

void push(benchmark::State& state, int count) {
  const Scene scene = boxes(count, Layout::table);
  World world(scene);
  TouchMemory memory = scene.memory();
  BodyContactState contacts = world.contact_state();
  world.touch({Vec3(0, 0, 2 * kHalf - 1e-3), Vec3::Zero()}, memory, contacts);
  for (auto _ : state) world.push(contacts, memory, 0.0);
}

[[maybe_unused]] const bool registered = [] {
  for (const int count : {1, 10, 100}) {
    const std::string n = std::to_string(count);
    benchmark::RegisterBenchmark(("world_step/apart/" + n).c_str(), step, count, Layout::apart);
    benchmark::RegisterBenchmark(("world_step/table/" + n).c_str(), step, count, Layout::table);
    if (count >= kPile)
      benchmark::RegisterBenchmark(("world_step/piles/" + n).c_str(), step, count, Layout::piles);
    benchmark::RegisterBenchmark(("world_touch/" + n).c_str(), touch, count);
    benchmark::RegisterBenchmark(("world_push/" + n).c_str(), push, count);
  }
  for (const int count : {1, 10, 100, 1000}) {
    const std::string n = std::to_string(count);
    constexpr double kFar = 1.0 / kPitch;
    const auto stroked = [&](const char* name, const Shape& shape, double apart) {
      benchmark::RegisterBenchmark(("moving/" + std::string(name) + n).c_str(), stroke, count,
                                   shape, apart);
    };
    stroked("crowd/boxes/", Box{Vec3::Constant(kHalf)}, 1.0);
    stroked("far/boxes/", Box{Vec3::Constant(kHalf)}, kFar);
    stroked("crowd/meshes/", mesh(), 1.0);
    stroked("far/meshes/", mesh(), kFar);
    benchmark::RegisterBenchmark(("moving/load/" + n).c_str(), load, count)
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("world_step/apart/1000", step, 1000, Layout::apart);
  return true;
}();

}  // namespace
}  // namespace feltwire::world_bench
