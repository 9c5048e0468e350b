// arm_tick/SCENE: a servo period of the simulated arm with its controller (two steps of physics).
//   `arm` is in free space, `table` presses on a table, `box` has a box in the gripper.
// world_arm: a step of the server's world in scenes/arm/workcell.json, with its arm at home.

#include <benchmark/benchmark.h>

#include <string>

#include "client/simulated_robots/arm.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/scene/world_arm.hpp"

namespace feltwire::arm_bench {
namespace {

void tick(benchmark::State& state, const std::string& scene, const Vec3& place, double gripper) {
  ArmConfig config;
  config.file = std::string(FELTWIRE_SOURCE_DIR) + "/scenes/arm/" + scene + ".xml";
  config.gripper = 0.08;
  Arm arm(config);
  FollowerTarget target{arm.read(Nanoseconds(0)).pose, 0.08};
  const Vec3 from = target.pose.position;
  Nanoseconds now{0};
  const auto next = [&] {
    arm.write(target);
    now += std::chrono::milliseconds(1);
    return arm.read(now);
  };
  constexpr int kWay = 2000, kRest = 1000;  // [ticks]
  for (int i = 1; i <= kWay; ++i) {
    target.pose.position = from + (place - from) * (static_cast<double>(i) / kWay);
    next();
  }
  target.gripper = gripper;
  for (int i = 0; i < kRest; ++i) next();
  for (auto _ : state) benchmark::DoNotOptimize(next());
}

void world_arm(benchmark::State& state) {
  const Scene scene = load_scene(FELTWIRE_SOURCE_DIR "/scenes/arm/workcell.json");
  World world(scene);
  WorldArm arm(scene.seats().front(), world);
  TeleopLink link(scene.seats().front());
  link.seat_robot(1);
  Nanoseconds now{0};
  for (auto _ : state) {
    arm.drive(world, link, now);
    benchmark::DoNotOptimize(world.step());
    arm.sense(world);
    now += std::chrono::milliseconds(1);
  }
}

BENCHMARK(world_arm);
BENCHMARK_CAPTURE(tick, arm, "arm", Vec3(0.45, 0.0, 0.4), 0.08)->Name("arm_tick/arm");
BENCHMARK_CAPTURE(tick, table, "table", Vec3(0.45, 0.0, 0.29), 0.0)->Name("arm_tick/table");
BENCHMARK_CAPTURE(tick, box, "box", Vec3(0.45, 0.0, 0.225), 0.03)->Name("arm_tick/box");

}  // namespace
}  // namespace feltwire::arm_bench
