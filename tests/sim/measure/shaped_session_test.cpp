// Whole sessions of the mode shaped, over links that lose and delay: no hand gets more than the
// device burned, and what the local model covers is felt as in process.

#include <gtest/gtest.h>

#include <algorithm>

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

NetworkRunResult run(const Hand& hand, const char* link, bool local_model, HandPath path) {
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
  return run_network(floor(), options);
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
    const Fidelity felt = fidelity(std::span(result.samples).subspan(result.samples.size() / 2));
    EXPECT_GT(felt.ratio(), 0.9) << link;
    if (near == 0.0) near = felt.ratio();
    EXPECT_NEAR(felt.ratio(), near, 0.05) << link;
  }
}

}  // namespace
}  // namespace feltwire::shaped_session_test
