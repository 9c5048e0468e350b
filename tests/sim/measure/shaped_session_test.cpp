// Tests complete sessions of the mode `shaped` over links with loss and delay. No hand may get more
// energy than the device dissipated. Contact within the local model must equal contact in process.

#include <gtest/gtest.h>

#include <algorithm>

#include "core/scene_file/load_scene.hpp"
#include "sim/hands/eight_hands.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire::shaped_session_test {
namespace {

constexpr double kStiffness = 4e4;  // [N/m]
constexpr double kPress = 3.0;      // [N]

Scene floor() {
  return Scene(
      "floor",
      {Object{
          .name = "floor",
          .shape = Plane{},
          .pose = {},
          .material = {.stiffness = kStiffness, .static_friction = 0.4, .dynamic_friction = 0.4}}});
}

NetworkRunOptions options_of(const Hand& hand, const char* link, bool local_model, HandPath path) {
  NetworkRunOptions options;
  options.hand.spec = builtin_device("simulated");
  options.hand.hand = hand;
  options.hand.task.path = path;
  options.hand.task.air = 1.0;
  options.hand.task.depth = kPress / hand.stiffness;
  options.parameters.mode = "shaped";
  options.parameters.local_model = local_model;
  options.link = parse_link(link);
  options.duration = 4.0;
  return options;
}

NetworkRunResult run(const Hand& hand, const char* link, bool local_model, HandPath path) {
  return run_network(floor(), options_of(hand, link, local_model, path));
}

double felt(const NetworkRunResult& result) {
  return fidelity(std::span(result.samples).subspan(result.samples.size() / 2)).ratio();
}

constexpr const char* kBad = "delay=20,jitter=10,order=free,loss=10,burst=4,duplicate=5,seed=3";

TEST(ShapedSession, NoHandGetsMoreThanTheDeviceBurned) {
  for (const NamedHand& named : kEightHands)
    for (const char* link : {"delay=0", "delay=2.5", kBad})
      for (const bool local_model : {false, true})
        for (const HandPath path : {HandPath::slide, HandPath::taps}) {
          const NetworkRunResult result = run(named.hand, link, local_model, path);
          EXPECT_GE(result.least_device_margin, -1e-6)
              << named.name << ' ' << link << ' ' << local_model;
          EXPECT_GT(result.servo.max_force, 0.05) << named.name << ' ' << link;
        }
}

TEST(ShapedSession, AStiffWallIsFeltAtAnyRoundTripWhereTheSurfacesTravel) {
  double near = 0.0;
  for (const char* link : {"delay=0", "delay=25", "delay=50", kBad}) {
    const NetworkRunResult result = run({}, link, true, HandPath::slide);
    EXPECT_GT(felt(result), 0.9) << link;
    if (near == 0.0) near = felt(result);
    EXPECT_NEAR(felt(result), near, 0.05) << link;
  }
}

/// Three patches of a fine mesh are valid for a few millimetres only. Such patches come too late
/// for a hand that moves.
TEST(ShapedSession, AFineMeshIsFeltAtAnyRoundTripWhereItTravelsWhole) {
  const Scene bunny = load_scene(FELTWIRE_SOURCE_DIR "/scenes/bunny.json");
  double near = 0.0;
  for (const char* link : {"delay=0", "delay=25", "delay=50", kBad}) {
    NetworkRunOptions options = options_of({}, link, true, HandPath::slide);
    options.hand.task.center = bunny.start().position;
    const NetworkRunResult result = run_network(bunny, options);
    EXPECT_GT(felt(result), 0.9) << link;
    EXPECT_GE(result.least_device_margin, -1e-6) << link;
    if (near == 0.0) near = felt(result);
    EXPECT_NEAR(felt(result), near, 0.05) << link;
    EXPECT_EQ(result.servo.local_model.whole, result.servo.local_model.received);
  }
  NetworkRunOptions patches = options_of({}, "delay=50", true, HandPath::slide);
  patches.hand.task.center = bunny.start().position;
  patches.whole_scene = false;
  const NetworkRunResult result = run_network(bunny, patches);
  EXPECT_EQ(result.servo.local_model.whole, 0u);
  EXPECT_LT(felt(result), 0.8 * near);
}

}  // namespace
}  // namespace feltwire::shaped_session_test
