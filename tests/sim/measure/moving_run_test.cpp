// Tests complete sessions with moving objects in virtual time. The results must be reproducible
// bitwise, and the port must be passive on any link. A test measures the rendered share of a
// carried weight.

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "core/base/csv.hpp"
#include "sim/lab/filters.hpp"
#include "sim/measure/network_run.hpp"
#include "tests/core/moving.hpp"

namespace feltwire::moving_run_test {
namespace {

using test::body;
using test::moving;
using test::object;

/// Returns a cabin of 150 g that moves up and down. Without a hand the cabin rests at 0.
Scene elevator() {
  Body cabin = body("cabin", 0.15);
  cabin.joint = Joint::slide;
  cabin.low = 0.0;
  cabin.high = 0.1;
  cabin.damping = 0.2;
  return moving({object("cabin", Box{Vec3(0.03, 0.03, 0.01)}, {.stiffness = 800, .damping = 0.5})},
                {0}, {cabin});
}

/// A hand moves the cabin up by about 5 cm from below and down again, twice.
NetworkRunOptions carrying(BoundingSide side, const char* link) {
  NetworkRunOptions options;
  options.hand.spec = builtin_device("simulated");
  options.hand.task.path = HandPath::taps;
  options.hand.task.center = {0, 0, -0.01};
  options.hand.task.depth = 0.055;
  set_normal(options.hand.task, -Vec3::UnitZ());
  options.hand.task.frequency = 0.5;
  options.parameters.side = side;
  options.link = parse_link(link);
  options.duration = 4.0;
  return options;
}

TEST(MovingRun, IsTheSameTwiceAndPassiveOverABadLink) {
  const Scene scene = elevator();
  for (const BoundingSide side : {BoundingSide::client, BoundingSide::server, BoundingSide::both})
    for (const bool model : {false, true}) {
      if (model && side == BoundingSide::server) continue;
      NetworkRunOptions options =
          carrying(side, "delay=8,jitter=6,order=free,loss=10,duplicate=3,seed=5");
      options.parameters.local_model = model;
      const NetworkRunResult one = run_network(scene, options);
      const NetworkRunResult two = run_network(scene, options);
      ASSERT_EQ(one.samples.size(), two.samples.size());
      double highest = 0.0, felt = 0.0;
      for (std::size_t n = 0; n < one.samples.size(); ++n) {
        ASSERT_EQ(one.samples[n].held, two.samples[n].held);
        ASSERT_EQ(one.samples[n].position, two.samples[n].position);
        highest = std::max(highest, one.samples[n].position.z());
        felt = std::max(felt, one.samples[n].held.force().norm());
      }
      EXPECT_EQ(one.measured_port.violations(), 0u);
      EXPECT_GE(one.least_device_margin, -1e-9);
      EXPECT_EQ(one.server.world.resets, 0u);
      EXPECT_NEAR(static_cast<double>(one.server.world.steps), 4000.0, 1.0);
      EXPECT_GT(highest, 0.03);
      EXPECT_GT(felt, 0.5);  // The cabin presses on the hand.
    }
}

// The report of a reset must arrive and be counted, over a bad link too.
TEST(MovingRun, TheClientHearsThatWhatMovesWasPutBack) {
  NetworkRunOptions options = carrying(BoundingSide::client, "delay=8,loss=10,seed=5");
  options.hand.task.center = {0, 0, 0.17};
  options.duration = 3.0;
  // The body is light enough for the force of a device.
  const NetworkRunResult run = run_network(test::explosive(1e-6), options);
  EXPECT_GE(run.server.world.resets, 1u);
  EXPECT_GE(run.servo.replies.scene_resets, 1u);
  EXPECT_LE(run.servo.replies.scene_resets, run.server.world.resets);
  EXPECT_EQ(run.measured_port.violations(), 0u);
  const NetworkRunResult calm = run_network(elevator(), carrying(BoundingSide::client, "delay=0"));
  EXPECT_EQ(calm.servo.replies.scene_resets, 0u);
}

/// The rendered share of the commanded force, upwards and downwards.
struct Share {
  double up = 0.0, down = 0.0;
};

Share share_of(std::string_view mode, Storage storage) {
  NetworkRunOptions options = carrying(BoundingSide::client, "delay=0");
  options.parameters.mode = mode;
  options.parameters.storage = storage;
  const Scene scene = elevator();
  double felt[2] = {}, meant[2] = {};
  for (const NetworkSample& s : run_network(scene, options).samples) {
    if (std::abs(s.velocity.z()) < 0.01) continue;
    const int way = s.velocity.z() > 0.0 ? 0 : 1;
    felt[way] -= s.held.force().z();
    meant[way] -= s.ideal.force().z();
  }
  return {felt[0] / meant[0], felt[1] / meant[1]};
}

/// A weight returns the energy of its lift when it moves down. Minimal storage has discarded this
/// energy and renders little of the weight on the way down. Elastic storage keeps the energy and
/// renders the weight (docs/moving.md).
TEST(MovingRun, WhatTheBoundLeavesOfACarriedWeight) {
  const Share none = share_of("none", Storage::minimal);
  EXPECT_NEAR(none.up, 1.0, 0.02);
  EXPECT_NEAR(none.down, 1.0, 0.02);
  const Share minimal = share_of("contact_frame", Storage::minimal);
  const Share elastic = share_of("contact_frame", Storage::elastic);
  const Share tank = share_of("energy_tank", Storage::minimal);
  EXPECT_NEAR(minimal.up, 1.0, 0.02);
  EXPECT_NEAR(minimal.down, 0.06, 0.03);
  for (const Share& whole : {elastic, tank}) {
    EXPECT_NEAR(whole.up, 1.0, 0.02);
    EXPECT_NEAR(whole.down, 1.0, 0.02);
  }
}

/// The filter must step the bodies by the times of its rows.
TEST(MovingRun, TheTouchFilterMovesThingsOn) {
  const Scene scene = moving({object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                             {body("ball", 0.2)}, test::kWeightless);
  std::istringstream input("t,x,y,z\n0,-0.029,0,0\n0.01,-0.029,0,0\n0.5,-0.029,0,0\n");
  std::ostringstream output;
  EXPECT_EQ(filter_touch(input, output, scene), 0u);
  std::istringstream lines(output.str());
  std::string line;
  std::vector<double> forces;
  std::getline(lines, line);
  while (std::getline(lines, line)) forces.push_back(std::stod(line));
  ASSERT_EQ(forces.size(), 3u);
  EXPECT_NEAR(forces[0], -1.0, 1e-9);
  // m x'' = k (1 mm - x): the force follows a cosine until the contact ends.
  EXPECT_NEAR(forces[1], -std::cos(0.01 * std::sqrt(1000 / 0.2)), 0.03);
  EXPECT_EQ(forces[2], 0.0);  // The ball has left the hand.
}

}  // namespace
}  // namespace feltwire::moving_run_test
