// field/SHAPE: the distance and its gradient, at positions near the surface in random order.
// tool/CASE/POINTS: one step of a tool with a body that a hand moves (docs/fields.md). The tool is
//   far from everything, grazes a plate (points within a millimetre), lies on the plate, or is in a
//   hole.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/splitmix.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire::field_bench {
namespace {

Shape grid_of(const Shape& solid, double resolution) {
  return Grid{std::make_shared<const DistanceGrid<float>>(solid_of(solid),
                                                          GridOptions{.resolution = resolution})};
}

void field(benchmark::State& state, const Shape& shape) {
  constexpr std::size_t kPlaces = 4096;
  std::vector<Vec3> places;
  for (std::uint64_t i = 0; i < kPlaces; ++i) {
    Vec3 p;
    for (std::uint64_t axis = 0; axis < 3; ++axis)
      p[static_cast<Eigen::Index>(axis)] =
          static_cast<double>(splitmix::draw(1, 3 * i + axis) >> 11) * 0x1p-52 - 1.0;
    places.push_back(0.089 * p.normalized());
  }
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(signed_distance(shape, Side::outside, places[n]));
    n = (n + 1) % kPlaces;
  }
}

struct Case {
  const char* name;
  Shape body, solid;
  Side side;
  Vec3 position;  // [m] position of the hand
};

std::vector<Case> cases() {
  const Shape box = Box{Vec3(0.03, 0.02, 0.01)}, rod = Cylinder{0.01, 0.015};
  const Shape plate = grid_of(Box{Vec3(0.08, 0.08, 0.02)}, 1e-3);
  const Shape hole = grid_of(Cylinder{0.0102, 0.03}, 0.5e-3);
  return {{"far", box, plate, Side::outside, {0.0, 0.0, 0.13}},
          {"graze", box, plate, Side::outside, {0.0, 0.0, 0.0305}},
          {"lie", box, plate, Side::outside, {0.0, 0.0, 0.029}},
          {"hole", rod, hole, Side::inside, {3e-4, 0.0, 0.0}}};
}

void tool(benchmark::State& state, const Case& c, std::size_t points) {
  constexpr int kSegments = 128;
  constexpr double kTurns = 2.0, kPeriod = 1e-3, kSway = 1e-3;
  constexpr std::size_t kSteps = 500;  // one oscillation
  const BodyTool body(point_shell(tessellate(c.body, kSegments), points), {}, 2.4e-3);
  Object object;
  object.name = c.name;
  object.shape = c.solid;
  object.felt_from = c.side;
  BodyMemory memory;
  std::size_t n = 0;
  for (auto _ : state) {
    const double s = std::sin(2.0 * M_PI * kTurns * kPeriod * static_cast<double>(n));
    const Pose hand = moved({c.position, Quaternion::Identity()}, kSway * s * Vec3(1, 1, 0),
                            Vec3(0.0, 0.0, 0.3 * s));
    benchmark::DoNotOptimize(step_body(body, std::span(&object, 1), hand, kPeriod, memory));
    n = (n + 1) % kSteps;
  }
}

[[maybe_unused]] const bool registered = [] {
  const Shape ball = Sphere{0.09};
  benchmark::RegisterBenchmark("field/sphere", field, ball);
  benchmark::RegisterBenchmark("field/grid_1mm", field, grid_of(ball, 1e-3));
  for (const Case& c : cases())
    for (const std::size_t points : {1000u, 10'000u})
      benchmark::RegisterBenchmark(
          ("tool/" + std::string(c.name) + "/" + std::to_string(points)).c_str(), tool, c, points);
  return true;
}();

}  // namespace
}  // namespace feltwire::field_bench
