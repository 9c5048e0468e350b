// Tests the loop in six degrees of freedom: force balance, energy as one port and as two, and
// complete sessions.

#include "sim/measure/six_dof.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "core/bounding/device_account.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/scene_file/load_scene.hpp"
#include "sim/hands/eight_hands.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire::six_dof_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

SixDofSetup still() {
  SixDofSetup setup;
  setup.hand.spec = builtin_device("simulated_6dof");
  setup.hand.hand = with_wrist(Hand{});
  setup.hand.task.clearance = setup.hand.task.depth = 0.0;
  setup.bounding.mode = kUnbounded;
  setup.bounding.period = kPeriod;
  setup.bounding.damping = setup.hand.spec.damping;
  setup.bounding.rotational_damping = setup.hand.spec.rotational_damping;
  setup.bounding.rotation = true;
  return setup;
}

TEST(SixDof, RestsWhereWristAndTorqueBalance) {
  SixDofSetup setup = still();
  setup.hand.spec.rotation.friction = 0.0;
  const Vec3 torque(0.04, -0.02, 0.01);
  const auto samples = run_six_dof(
      [&](const Pose&, const Vec3&, double) { return Command{.torque = torque}; }, setup);
  const Vec3 turn = rotation_between(Quaternion::Identity(), samples.back().pose.orientation);
  EXPECT_NEAR((turn - torque / setup.hand.hand.rotational_stiffness).norm(), 0.0, 1e-9);
  EXPECT_EQ(samples.back().rendered.torque, torque);
}

/// Compares the brick on the table with and without datagrams. Forces and torques must be equal.
TEST(SixDof, ASessionWithoutDelayIsTheDirectLoop) {
  const Scene scene = parse_scene(R"({ "name": "table",
    "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 600 } },
    "materials": [ { "name": "wood", "stiffness": 1500, "static_friction": 0.4, "dynamic_friction": 0.3 } ],
    "objects": [ { "name": "table", "plane": {}, "material": "wood" } ] })",
                                  "table");
  NetworkRunOptions options;
  options.hand = still().hand;
  options.hand.task.center = {0.0, 0.0, 0.01};
  options.hand.task.depth = 0.01;
  options.hand.task.clearance = 0.005;
  options.hand.wrist = {WristPath::tilt, 0.2};
  options.duration = 1.5;
  const NetworkRunResult network = run_network(scene, options);
  SixDofSetup setup = still();
  setup.hand = options.hand;
  setup.bounding = bounding_config(options.parameters, options.hand.spec);
  setup.delay = 1;
  setup.duration = options.duration;
  const auto direct = run_six_dof(pose_environment(scene), setup);
  ASSERT_EQ(network.samples.size(), direct.size());
  double largest = 0.0;
  for (std::size_t n = 0; n < direct.size(); ++n) {
    // A client normalizes its orientation before sending. The last bits may differ.
    const NetworkSample& sent = network.samples[n];
    ASSERT_NEAR((sent.held.torque - direct[n].rendered.torque).norm(), 0.0, 1e-9) << n;
    ASSERT_NEAR((sent.held.force() - direct[n].rendered.force()).norm(), 0.0, 1e-9) << n;
    ASSERT_NEAR(rotation_between(sent.orientation, direct[n].pose.orientation).norm(), 0.0, 1e-9)
        << n;
    largest = std::max(largest, direct[n].rendered.torque.norm());
  }
  EXPECT_GT(largest, 0.01) << "[N m]";
  EXPECT_EQ(network.measured_port.violations(), 0u);
}

AccountConfig any_hand() { return any_hand_account(builtin_device("simulated_6dof"), kPeriod); }

TEST(SixDof, AsTwoPortsAMovementNeverPaysForATorque) {
  for (const Ports ports : {Ports::one, Ports::two}) {
    PortAccounts accounts(any_hand(), ports);
    // Free motion fills the account of the translation.
    for (int n = 0; n < 1000; ++n)
      accounts.step({.displacement = {3e-4, 0.0, 0.0}, .hold_time = kPeriod, .command = {}});
    const Command command{.elastic = {2.0, 0.0, 0.0}, .torque = {0.0, 0.1, 0.0}};
    const Command held = accounts.step({.hold_time = kPeriod, .command = command});
    EXPECT_EQ(held.elastic, command.elastic);
    EXPECT_EQ(held.torque, ports == Ports::one ? command.torque : Vec3(Vec3::Zero()));
  }
}

/// The hand moves along the held force with v = f / (2 b), which extracts the most energy, or at
/// random.
TEST(SixDof, NeitherOnePortNorTwoGiveAGreedyHandEnergy) {
  const DeviceSpec spec = builtin_device("simulated_6dof");
  const double b = spec.damping.least(), b_r = spec.rotational_damping.least();
  for (const Ports ports : {Ports::one, Ports::two}) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    double by_torque = 0.0;
    for (int run = 0; run < 50; ++run) {
      PortAccounts accounts(any_hand(), ports);
      PortEnergy both(spec.damping, spec.rotational_damping, kPeriod);
      PortEnergy force = both, torque = both;
      Command held;
      for (int n = 0; n < 1000; ++n) {
        const auto noise = [&](double size) {
          return Vec3(size * Vec3(normal(random), normal(random), normal(random)));
        };
        const bool greedy = n % 3 != 0;
        const Vec3 displacement = greedy ? Vec3(0.5 * kPeriod / b * held.force()) : noise(2e-4);
        const Vec3 rotation = greedy ? Vec3(0.5 * kPeriod / b_r * held.torque) : noise(2e-3);
        both.step(held, displacement, rotation, kPeriod);
        force.step(held, displacement, Vec3::Zero(), kPeriod);
        torque.step(held, Vec3::Zero(), rotation, kPeriod);
        held = accounts.step({.displacement = displacement,
                              .rotation = rotation,
                              .hold_time = kPeriod,
                              .command = {.elastic = noise(3.0), .torque = noise(0.3)}});
      }
      ASSERT_EQ(both.violations(), 0u) << run;
      if (ports == Ports::two) {
        ASSERT_EQ(force.violations(), 0u) << run;
        ASSERT_EQ(torque.violations(), 0u) << run;
      }
      by_torque = std::max(by_torque, -torque.least_margin());
    }
    if (ports == Ports::one) {
      EXPECT_GT(by_torque, 1e-6) << "[J] as one port, force pays for torque";
    }
  }
}

TEST(SixDof, BehindTheAccountNoHandGetsEnergyFromAStiffStop) {
  for (const Ports ports : {Ports::one, Ports::two}) {
    double without = 0.0;
    for (const NamedHand& named : kEightHands) {
      SixDofSetup setup = still();
      setup.hand.hand = with_wrist(named.hand);
      setup.hand.wrist = {WristPath::tilt, 0.45};
      setup.duration = 2.0;
      setup.ports = ports;
      const PoseEnvironment stop = [](const Pose& pose, const Vec3&, double) {
        const Vec3 turn = rotation_between(Quaternion::Identity(), pose.orientation);
        return Command{.torque = -64.0 * std::max(0.0, turn.norm() - 0.1) * turn.normalized()};
      };
      const auto made = [&] {
        return energy_made(setup.hand.spec, run_six_dof(stop, setup), kPeriod).measured;
      };
      without = std::max(without, made());
      setup.bounding.mode = "midpoint";
      setup.account = account_config(setup.hand.spec, kPeriod);
      EXPECT_LE(made(), 1e-12) << named.name;
    }
    EXPECT_GT(without, 1e-3) << "[J] what a stop of 64 N m/rad makes where nothing bounds it";
  }
}

TEST(SixDof, RefusesWhatDoesNotTurn) {
  SixDofSetup setup = still();
  setup.hand.spec = builtin_device("simulated");
  const PoseEnvironment nothing = [](const Pose&, const Vec3&, double) { return Command{}; };
  EXPECT_THAT([&] { run_six_dof(nothing, setup); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("rotation")));
  setup = still();
  setup.delay = -1;
  EXPECT_THROW(run_six_dof(nothing, setup), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::six_dof_test
