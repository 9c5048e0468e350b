// Tests how a hand and its robot stop after each fault (PROTOCOL.md, "A robot that follows").

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"
#include "tests/core/support.hpp"

namespace feltwire::teleoperation_fault_test {
namespace {

using test::Teleoperation;
using enum LinkState;

constexpr double kStep = 0.25e-3;  // [m] per sample at the robot's speed limit
// [N] the largest fall of the force per tick: the largest force ends within half the hold time, and
// the hand's own movement adds a part.
constexpr double kFall = 8.9 / 50.0 + 0.05;

/// Engages and presses about 10 mm deep.
void press(test::RobotSession& bench) {
  bench.engage();
  bench.move(Vec3(0.0, 0.0, -0.045), 0.6);
  bench.run(0.5);
  ASSERT_EQ(bench.state(), engaged);
  ASSERT_GE(bench.force(), 1.0);
  bench.fastest_fall = bench.farthest_step = 0.0;
}

TEST(TeleoperationFault, EachEngagementBeginsWhereTheRobotIs) {
  test::Random random(7);
  Teleoperation bench("delay=10,jitter=2,loss=5,seed=4", {.scale = 0.5});
  for (int i = 0; i < 40; ++i) {
    bench.hand.pressed = false;
    // The clutch is pressed during this movement.
    bench.move(random.uniform(0.0, 0.05) * random.direction(), 0.3);
    bench.run(0.3);
    ASSERT_EQ(bench.state(), i == 0 ? ready : clutched);
    const Vec3 held = bench.commanded.position;
    bench.hand.pressed = true;
    for (int n = 0; n < 100; ++n) {
      bench.tick();
      ASSERT_LE((bench.commanded.position - held).norm(), 1e-9) << i;
    }
    ASSERT_EQ(bench.state(), engaged);
    bench.move(random.uniform(0.0, 0.01) * random.direction(), 0.3);
  }
  EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
}

TEST(TeleoperationFault, ASilentHandLeavesTheRobotHolding) {
  Teleoperation bench;
  press(bench);
  bench.hand_cut = true;
  bench.run(0.102);
  EXPECT_EQ(bench.state(), hold);
  EXPECT_FALSE(bench.follower.follows());
  EXPECT_EQ(bench.force(), 0.0) << "its answers are too old";
  EXPECT_LE(bench.fastest_fall, kFall);
  const Vec3 held = bench.commanded.position;
  bench.move(Vec3(0.0, 0.0, -0.05), 0.3);
  bench.hand_cut = false;
  bench.run(0.3);
  EXPECT_EQ(bench.state(), hold) << "the switch was never released";
  EXPECT_LE((bench.commanded.position - held).norm(), 1e-9) << "nothing of what was missed is done";
  bench.engage();
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
  EXPECT_GE(bench.commanded.position.z(), held.z()) << "the surface is met where the hand is";
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationFault, ARobotThatIsCutOffHoldsAndComesBack) {
  Teleoperation bench;
  press(bench);
  bench.robot_cut = true;
  bench.run(0.102);
  EXPECT_FALSE(bench.follower.follows());
  EXPECT_EQ(bench.state(), fault);
  bench.run(0.1);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_LE(bench.fastest_fall, kFall);
  const Vec3 held = bench.commanded.position;
  bench.move(Vec3(0.0, 0.0, 0.01), 0.3);
  bench.robot_cut = false;
  bench.run(0.3);
  EXPECT_EQ(bench.state(), fault) << "the switch was never released";
  EXPECT_LE((bench.commanded.position - held).norm(), 1e-9);
  bench.engage();
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationFault, ARobotThatIsStoppedIsAFault) {
  Teleoperation bench;
  press(bench);
  bench.robot.stop(true);
  bench.run(0.01);
  EXPECT_EQ(bench.state(), fault);
  EXPECT_FALSE(bench.follower.follows());
  bench.robot.stop(false);
  bench.run(0.2);
  EXPECT_EQ(bench.state(), fault);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_LE(bench.fastest_fall, kFall);
  bench.engage();
  EXPECT_EQ(bench.state(), engaged);
}

TEST(TeleoperationFault, AServerThatIsStartedAnewKnowsNobody) {
  Teleoperation bench;
  press(bench);
  bench.server = std::make_unique<SceneSessions>(bench.scene, std::chrono::seconds(2), 8);
  bench.run(0.15);
  EXPECT_EQ(bench.state(), disabled);
  EXPECT_FALSE(bench.follower.follows());
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_LE(bench.fastest_fall, kFall);
}

TEST(TeleoperationFault, AHandThatLeavesDisablesAndAnotherOneBeginsAtReady) {
  Teleoperation bench;
  press(bench);
  bench.server->answer(control::LeaveRequest{Teleoperation::kHand}, 0, {}, bench.now);
  bench.run(0.15);
  EXPECT_EQ(bench.state(), disabled);
  EXPECT_FALSE(bench.follower.follows());
  const Vec3 held = bench.commanded.position;
  constexpr std::uint64_t kAgain = 0x900;
  bench.join(kAgain, Role::operator_);
  bench.hand_datagrams.resume(kAgain, test::keys(kAgain));
  bench.servo.reconnected(true);
  bench.run(0.3);
  EXPECT_EQ(bench.state(), disabled) << "the switch is taped";
  bench.engage();
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
  EXPECT_GE(bench.commanded.position.z(), held.z());
}

TEST(TeleoperationFault, AHandThatJumpsIsNotFollowed) {
  Teleoperation bench;
  press(bench);
  const Vec3 held = bench.commanded.position;
  bench.hand.put(bench.hand.meant + Vec3(0.05, 0.0, 0.0));
  bench.run(0.05);
  EXPECT_EQ(bench.state(), hold);
  EXPECT_LE((bench.commanded.position - held).norm(), kStep);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationFault, AWrenchAboveTheLimitHolds) {
  Teleoperation bench("delay=0", {.force = 2.5});
  bench.engage();
  bench.move(Vec3(0.0, 0.0, -0.06), 0.6);
  bench.run(0.3);
  EXPECT_EQ(bench.state(), hold);
  EXPECT_LE(bench.robot.force().norm(), 4.0);
  bench.engage();
  EXPECT_EQ(bench.state(), engaged) << "to be led out";
  bench.move(Vec3(0.0, 0.0, 0.03), 0.6);
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_EQ(bench.robot.force().norm(), 0.0);
}

/// Makes a false report of energy that would allow any force on the hand.
void lie_of_energy(RobotState& state) {
  state.energy.pushed = state.energy.given = 1e9 + static_cast<double>(state.index);
}

TEST(TeleoperationFault, ARobotThatLiesOfEnergyBuysNothing) {
  Teleoperation bench;
  bench.lie = lie_of_energy;
  press(bench);
  bench.move(Vec3(0.0, 0.0, 0.01), 0.2);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationFault, ATrustedRobotThatLiesBuysNoMoreThanItsTrust) {
  constexpr RemoteTrust kTrust{.per_contact = 0.01, .power = 0.5};
  Teleoperation bench("delay=0", {}, kTrust);
  bench.lie = lie_of_energy;
  press(bench);
  EXPECT_LE(bench.made(), kTrust.per_contact);
}

TEST(TeleoperationFault, ARobotThatLiesOfItsContactGivesTheHandNoEnergy) {
  for (const bool garbage : {true, false}) {
    Teleoperation bench;
    test::Random random(8);
    bench.engage();
    bench.lie = [&](RobotState& s) {
      s.contact = {.surface = 1 + static_cast<std::uint32_t>(random.uniform(0.0, 3.0)),
                   .touching = random.chance(0.5),
                   .point = random.uniform(0.0, 0.1) * random.direction(),
                   .normal = random.direction(),
                   .stiffness = std::pow(10.0, random.uniform(0.0, 5.0)),
                   .friction = random.uniform(0.0, 2.0),
                   .velocity = random.uniform(0.0, 5.0) * random.direction()};
      s.pose.position = random.uniform(0.0, 10.0) * random.direction();
      if (garbage && random.chance(0.3))
        s.contact.point.x() = std::numeric_limits<double>::quiet_NaN();
      if (garbage && random.chance(0.3)) s.pose.orientation.coeffs().setZero();
    };
    for (int i = 0; i < 20; ++i) bench.move(0.02 * random.direction(), 0.2);
    EXPECT_LE(bench.made(), 0.0);
    EXPECT_TRUE(bench.servo.held().finite());
  }
}

TEST(TeleoperationFault, WhatNoReplyCanCarryIsLeftOut) {
  Teleoperation bench("delay=0", {.scale = 0.001});
  bench.engage();
  int which = 0;
  bench.lie = [&](RobotState& s) {
    s.contact = {.surface = 1,
                 .touching = true,
                 .point = Vec3(which == 0 ? 900.0 : 0.0, 0.0, 0.0),
                 .normal = Vec3::UnitZ(),
                 .stiffness = which == 1 ? 1e-44 : 1.0,
                 .velocity = Vec3(which == 2 ? 50.0 : 0.0, 0.0, 0.0)};
    if (which == 3) s.energy.given = 1e308;
  };
  for (; which < 4; ++which) {
    bench.run(0.02);
    EXPECT_EQ(bench.state(), engaged);
    EXPECT_EQ(bench.servo.remote()->remote().contact.surface, which == 3 ? 1u : 0u) << which;
  }
  for (const std::uint64_t dropped : bench.hand_datagrams.dropped()) EXPECT_EQ(dropped, 0u);
}

/// A robot with readings that jump, because an encoder lost its counts or the robot was thrown.
struct ShiftedRobot final : Follower {
  PointRobot robot{test::wall_scene(), Vec3(0.0, 0.0, 0.02)};
  Vec3 shift = Vec3::Zero();  // [m] shift of the readings
  const FollowerSpec& spec() const override { return robot.spec(); }
  FollowerReading read(Nanoseconds now) noexcept override {
    FollowerReading reading = robot.read(now);
    reading.pose.position += shift;
    return reading;
  }
  FollowerTarget write(const FollowerTarget& target) noexcept override {
    return robot.write(target);
  }
  void hold() noexcept override { robot.hold(); }
};

TEST(TeleoperationFault, ARobotThatTeleportsIsAFaultAndItsHandLosesTheForceSlowly) {
  for (const Vec3& shift : {Vec3(0.0, 0.0, 0.3), Vec3(0.0, 0.0, -0.3), Vec3(0.2, 0.1, 0.0)}) {
    ShiftedRobot robot;
    test::RobotSession bench(robot);
    press(bench);
    robot.shift = shift;
    bench.run(0.3);
    EXPECT_EQ(bench.state(), fault);
    EXPECT_GE(bench.follower.statistics().faults, 100u) << "it does not believe the readings";
    EXPECT_FALSE(bench.follower.follows());
    EXPECT_EQ(bench.force(), 0.0);
    EXPECT_LE(bench.fastest_fall, kFall);
    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
    EXPECT_LE(bench.made(), 0.0);
    bench.engage();
    EXPECT_EQ(bench.state(), fault) << "it still reads another place";
    robot.shift.setZero();
    bench.run(0.1);
    bench.engage();
    EXPECT_EQ(bench.state(), engaged);
    bench.move(Vec3(0.0, 0.0, 0.03), 0.4);
    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
    EXPECT_LE(bench.made(), 0.0);
  }
}

TEST(TeleoperationFault, DatagramsDoubledAndOvertakenChangeNothing) {
  Teleoperation bench("delay=20,jitter=5,loss=5,duplicate=20,reorder=20,seed=9");
  press(bench);
  bench.move(Vec3(0.0, 0.0, 0.045), 0.6);
  bench.run(0.5);
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_GT(bench.server->counters().samples.duplicates, 100u);
}

TEST(TeleoperationFault, TheRobotHasOneSeat) {
  Teleoperation bench;
  const auto refused = [](const control::Message& answer) {
    const auto* no = std::get_if<control::Refused>(&answer);
    return no == nullptr ? std::string() : no->reason;
  };
  EXPECT_EQ(refused(bench.ask_to_join(0x900, Role::follower)),
            "the seat of scene 'empty' is taken: a robot sits there; end its session first");
  bench.server->answer(control::LeaveRequest{Teleoperation::kRobot}, 0, {}, bench.now);
  EXPECT_EQ(refused(bench.ask_to_join(0x900, Role::follower)), "");

  const Scene without = *test::wall_scene();
  SceneSessions sessions(without, std::chrono::seconds(2), 8);
  const control::JoinRequest request{"tester", "wall", bench.hand.spec(), bench.parameters,
                                     Role::follower};
  EXPECT_EQ(refused(sessions.answer(request, 1, test::keys(1), bench.now)),
            "scene 'wall' has no seat for a robot; give it a \"remote\"");
}

TEST(TeleoperationFault, NobodySpeaksForAnother) {
  Teleoperation bench;
  bench.run(0.1);
  const auto drops = [&] {
    return bench.server->counters().drops[static_cast<std::size_t>(DropReason::kind)];
  };
  const std::uint64_t before = drops();
  Encoder encoder;
  const SessionKeys hand = test::keys(Teleoperation::kHand),
                    robot = test::keys(Teleoperation::kRobot);
  Sealer as_hand(hand.suite, hand.up, 1000), as_robot(robot.suite, robot.up, 1000);
  RobotState state;
  state.index = 100000;
  SampleBatch batch;
  batch.count = 1;
  batch.samples[0].index = 100000;
  DatagramBuffer out;
  bench.server->receive(
      as_hand.seal(DatagramKind::follower_state, Teleoperation::kHand, encoder.state(state), out),
      bench.hand_peer, bench.now, bench.room);
  EXPECT_EQ(drops(), before + 1);
  EXPECT_TRUE(bench.server
                  ->receive(as_robot.seal(DatagramKind::samples, Teleoperation::kRobot,
                                          encoder.samples(batch), out),
                            bench.robot_peer, bench.now, bench.room)
                  .empty());
  EXPECT_EQ(drops(), before + 2);
}

}  // namespace
}  // namespace feltwire::teleoperation_fault_test
