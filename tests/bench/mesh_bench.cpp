// mesh/CASE/TRIANGLES: the cost of a sample on a faceted sphere, r = 90 mm, 5 kN/m. The probe is 2
// mm inside, slides at 0.1 m/s and is sampled at 1 kHz.
//   glide, smooth     a point; smooth: the direction of its force is interpolated
//   ball              a ball of 1 mm
//   local_model,      a sample plus the surfaces near the tool (subtract glide or ball)
//   ball_model
//   build             the tree (and neighbours) from vertices and triangles
//   objects           this number of meshes; the probe touches one of them
// Further results: the time of single samples, p50 and p99.9, including the clock's reading; the
// largest and mean error of the direction [deg]; the largest change of the force between samples
// [N], and its part beyond the rotation from facet to facet; memory [MB].

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "core/contact/contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "core/scene/scene.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::mesh_bench {
namespace {

constexpr double kRadius = 0.09, kDepth = 0.002, kStiffness = 5000.0;  // [m], [N/m]
constexpr double kSpeed = 0.1, kPeriod = 1e-3;                         // [m/s], [s]
constexpr double kMega = 1e6;

const TriangleSoup& sphere(int level) {
  static std::map<int, TriangleSoup> made;
  const auto [at, added] = made.try_emplace(level);
  if (added) at->second = test::icosphere(kRadius, level);
  return at->second;
}

Object object_of(const TriangleSoup& soup, const MeshOptions& options) {
  Object object;
  object.name = "sphere";
  object.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(soup), options)};
  object.material.stiffness = kStiffness;
  return object;
}

Vec3 outward(std::size_t sample) {
  const double turn = kSpeed * kPeriod / kRadius * static_cast<double>(sample);
  const double tilt = 0.3 * std::sin(0.37 * turn);
  return {std::cos(turn) * std::cos(tilt), std::sin(turn) * std::cos(tilt), std::sin(tilt)};
}

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI;
}

void glide(benchmark::State& state, int level, const MeshOptions& options) {
  using Clock = std::chrono::steady_clock;
  const Object object = object_of(sphere(level), options);
  ContactMemory memory;
  std::vector<double> times;
  times.reserve(1 << 22);
  const TriangleMesh& mesh = std::get<Mesh>(object.shape).surface->mesh();
  double worst = 0.0, sum = 0.0, jump = 0.0, beyond = 0.0;
  Vec3 last = Vec3::Zero(), before_facet = Vec3::Zero();
  touch(object, {(kRadius + 0.01) * Vec3::UnitX(), Vec3::Zero()}, memory);
  std::size_t n = 0;
  for (auto _ : state) {
    const Vec3 out = outward(n++);
    const Tool tool{(kRadius + options.radius - kDepth) * out, Vec3::Zero()};
    const auto before = Clock::now();
    const Command command = touch(object, tool, memory);
    const auto after = Clock::now();
    if (times.size() < times.capacity())
      times.push_back(std::chrono::duration<double, std::micro>(after - before).count());
    const double error = degrees_between(command.elastic, out);
    const Vec3 facet = triangle_normal(mesh.corners(memory.feature.triangle));
    if (n > 2) {
      worst = std::max(worst, error);
      const double change = (command.elastic - last).norm();
      jump = std::max(jump, change);
      beyond = std::max(beyond, change - command.elastic.norm() * (facet - before_facet).norm());
    }
    before_facet = facet;
    sum += error;
    last = command.elastic;
  }
  std::sort(times.begin(), times.end());
  state.counters["p50_us"] = times[times.size() / 2];
  state.counters["p99.9_us"] = times[times.size() * 999 / 1000];
  state.counters["mean_deg"] = sum / static_cast<double>(n);
  state.counters["worst_deg"] = worst;
  state.counters["jump_N"] = jump;
  state.counters["beyond_N"] = beyond;
}

void build(benchmark::State& state, int level) {
  const TriangleSoup& soup = sphere(level);
  double memory = 0.0;
  for (auto _ : state) {
    const MeshSurface surface{TriangleMesh(soup)};
    memory = static_cast<double>(surface.memory()) / kMega;
  }
  state.counters["MB"] = memory;
}

void build_tree(benchmark::State& state, int level) {
  const TriangleMesh mesh(sphere(level));
  std::vector<Bounds> boxes(mesh.triangles().size());
  for (std::uint32_t t = 0; t < boxes.size(); ++t)
    for (const Vec3& corner : mesh.corners(t)) boxes[t].add(corner);
  double memory = 0.0;
  for (auto _ : state) {
    const BoxTree tree(boxes);
    memory = static_cast<double>(tree.memory()) / kMega;
  }
  state.counters["MB"] = memory;
}

void objects(benchmark::State& state, int count) {
  constexpr int kLevel = 3, kRow = 32;
  constexpr double kApart = 0.25;  // [m]
  const auto surface = std::make_shared<MeshSurface>(TriangleMesh(sphere(kLevel)));
  std::vector<Object> all;
  for (int i = 0; i < count; ++i) {
    Object object;
    object.name = "ball " + std::to_string(i);
    object.shape = Mesh{surface};
    object.pose.position = kApart * Vec3(i % kRow, i / kRow, 0.0);
    object.material.stiffness = kStiffness;
    all.push_back(object);
  }
  const Scene scene("many", std::move(all));
  TouchMemory memory = scene.memory();
  std::size_t n = 0;
  Command command;
  scene.touch({(kRadius + 0.01) * Vec3::UnitX(), Vec3::Zero()}, memory);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        command = scene.touch({(kRadius - kDepth) * outward(n++), Vec3::Zero()}, memory));
  state.counters["N"] = command.elastic.norm();
}

/// Runs the query of a session that sends a local model with every reply, on this path.
void model(benchmark::State& state, int level, const MeshOptions& options) {
  const Scene scene("sphere", {object_of(sphere(level), options)});
  TouchMemory memory = scene.memory();
  double reach = 0.0;
  std::size_t n = 0;
  for (auto _ : state) {
    const Vec3 position = (kRadius + options.radius - kDepth) * outward(n++);
    scene.touch({position, Vec3::Zero()}, memory);
    reach += local_model(scene, position, memory).reach;
  }
  state.counters["reach_mm"] = 1e3 * reach / static_cast<double>(n);
}

const bool registered = [] {
  for (const int level : {3, 5, 7, 8}) {
    const std::string triangles = "/" + std::to_string(20 << 2 * level);
    const MeshOptions point{}, smooth{.smooth = true}, ball{.radius = 0.001};
    benchmark::RegisterBenchmark(("mesh/glide" + triangles).c_str(), glide, level, point);
    benchmark::RegisterBenchmark(("mesh/local_model" + triangles).c_str(), model, level, point);
    benchmark::RegisterBenchmark(("mesh/ball_model" + triangles).c_str(), model, level, ball);
    benchmark::RegisterBenchmark(("mesh/smooth" + triangles).c_str(), glide, level, smooth);
    benchmark::RegisterBenchmark(("mesh/ball" + triangles).c_str(), glide, level, ball);
    benchmark::RegisterBenchmark(("mesh/build" + triangles).c_str(), build, level)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
    benchmark::RegisterBenchmark(("mesh/tree" + triangles).c_str(), build_tree, level)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  for (const int count : {1, 10, 100, 1000, 10000})
    benchmark::RegisterBenchmark(("mesh/objects/" + std::to_string(count)).c_str(), objects, count);
  return true;
}();

}  // namespace
}  // namespace feltwire::mesh_bench
