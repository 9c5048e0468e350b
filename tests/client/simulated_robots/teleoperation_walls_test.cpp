// Tests the walls of a robot's workspace over sealed datagrams and an emulated link. The robot must
// stay inside, and the hand must get the walls' force at its own rate. A movement away from a wall
// must have no delay.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"
#include "tests/core/support.hpp"

namespace feltwire::teleoperation_walls_test {
namespace {

using test::Teleoperation;
using enum LinkState;

constexpr double kTop = 0.05;  // [m] top of the workspace; the robot begins at 0.02
constexpr double kStiffness = 1000.0, kDepth = 5e-3;

RemoteSeat seat(double scale = 1.0) {
  RemoteSeat seat;
  seat.scale = scale;
  seat.workspace.add_box(Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, kTop));
  seat.wall_stiffness = kStiffness;
  seat.wall_depth = kDepth;
  return seat;
}

/// Returns the distance [m] of the target from the wall.
double room(const Teleoperation& bench) { return kTop - bench.commanded.position.z(); }

TEST(TeleoperationWalls, TheHandFeelsThemAndTheRobotStaysInside) {
  for (const char* link : {"delay=0", "delay=25,loss=2,seed=3"}) {
    for (const double scale : {1.0, 0.5}) {
      Teleoperation bench(link, seat(scale));
      bench.engage();
      bench.move(Vec3(0.0, 0.0, 0.08 / scale), 1.5);
      double least = 1.0;
      for (int i = 0; i < 1000; ++i) {
        bench.tick();
        least = std::min(least, room(bench));
      }
      ASSERT_EQ(bench.state(), engaged);
      EXPECT_GE(least, -1e-9);
      EXPECT_LE(room(bench), 1e-5) << link;
      // The spring has a limited depth. A hand with a target far beyond the wall gets the complete
      // force.
      EXPECT_NEAR(bench.force(), -kStiffness * kDepth, 0.1) << link << scale;
      EXPECT_LE(bench.made(), 0.0);
    }
  }
}

TEST(TeleoperationWalls, AHandThatComesBackMovesTheRobotAtOnce) {
  Teleoperation bench("delay=25,loss=2,seed=3", seat());
  bench.engage();
  bench.move(Vec3(0.0, 0.0, 0.2), 2.0);
  bench.run(0.5);
  EXPECT_LE(room(bench), 1e-5);
  const double hand = bench.hand.true_position().z();
  // The hand moves back by more than the stretch of its own spring at the wall.
  bench.move(Vec3(0.0, 0.0, -0.06), 1.0);
  bench.run(0.3);
  const double back = hand - bench.hand.true_position().z();
  EXPECT_GE(back, 0.02);
  EXPECT_EQ(bench.force(), 0.0);
  // The complete movement must move the robot, except for the offset that free movement restores.
  EXPECT_GE(room(bench), (1.0 - SurfaceOffset::kGivenBack) * back - 1e-3);
  EXPECT_LE(room(bench), back + 1e-3);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationWalls, ARestingHandFeelsThemWithoutSwing) {
  Teleoperation bench("delay=50,jitter=5,loss=5,seed=8", seat());
  bench.engage();
  bench.move(Vec3(0.0, 0.0, 0.04), 1.0);
  bench.run(1.0);
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 1000; ++i) {
    bench.tick();
    low = std::min(low, bench.hand.true_position().z());
    high = std::max(high, bench.hand.true_position().z());
  }
  EXPECT_LE(bench.force(), -1.0);
  EXPECT_LE(high - low, 50e-6) << "200 ms there and back";
  EXPECT_LE(bench.made(), 0.0);
}

TEST(TeleoperationWalls, EngagingAtAWallGivesNoKick) {
  Teleoperation bench("delay=25", seat());
  bench.engage();
  bench.move(Vec3(0.0, 0.0, 0.1), 1.5);
  bench.run(0.3);
  ASSERT_LE(room(bench), 1e-5);
  bench.hand.pressed = false;
  bench.run(0.5);
  EXPECT_EQ(bench.state(), clutched);
  EXPECT_EQ(bench.force(), 0.0);
  bench.hand.put(bench.hand.true_position());  // The hand rests, and its target is here.
  bench.run(0.1);
  const Vec3 hand = bench.hand.true_position();
  bench.hand.pressed = true;
  bench.run(0.5);
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE((bench.hand.true_position() - hand).norm(), 1e-4) << "nothing pushes a resting hand";
  EXPECT_NEAR(bench.force(), 0.0, 0.01);
  bench.move(Vec3(0.0, 0.0, 0.05), 0.5);  // The hand pushes on and must feel the wall.
  EXPECT_NEAR(bench.force(), -kStiffness * kDepth, 0.1);
  EXPECT_LE(room(bench), 1e-5);
  EXPECT_LE(bench.made(), 0.0);
}

/// A hand moves wildly on any network. The robot must stay inside, and the hand must get no energy.
TEST(TeleoperationWalls, AWildHandNeverGetsThrough) {
  test::Random random(21);
  for (const char* link :
       {"delay=0", "delay=40,jitter=20,loss=20,duplicate=10,reorder=10,seed=2"}) {
    RemoteSeat walled = seat();
    walled.workspace.add({Vec3(0.6, 0.0, 0.8), 0.0});
    walled.workspace.locked = {false, true, false};
    walled.workspace.turning_locked = true;
    walled.workspace.add_body(
        {{Vec3(-0.03, 0.0, 0.0), Quaternion::Identity()}, Vec3(0.0, 0.1, 0.0), 0.02});
    Teleoperation bench(link, walled);
    bench.engage();
    for (int i = 0; i < 40; ++i) {
      if (i % 10 == 9) bench.engage();
      const Vec3 way = random.uniform(0.0, 0.06) * random.direction();
      for (int n = 0; n < 10; ++n) {
        bench.move(0.1 * way, 0.02);
        ASSERT_LE(std::abs(bench.commanded.position.y()), 1e-12);
        for (const WorkspaceWall& wall : walled.workspace.view())
          ASSERT_GE(wall.clearance(bench.commanded.position), -1e-9);
        for (const KeepOutBody& body : walled.workspace.keep_out())
          ASSERT_GE(body.wall_at(bench.commanded.position).clearance(bench.commanded.position),
                    -1e-9);
      }
    }
    EXPECT_LE(bench.made(), 0.0) << link;
  }
}

/// A body in the way must act like a wall that moves with the robot. The robot must be able to pass
/// around the body.
TEST(TeleoperationWalls, ABodyIsFeltAndGoneAround) {
  for (const char* link : {"delay=0", "delay=25,loss=2,seed=3"}) {
    RemoteSeat around;
    around.wall_stiffness = kStiffness;
    around.wall_depth = kDepth;
    const KeepOutBody ball{{Vec3(0.0, 0.0, 0.10), Quaternion::Identity()}, Vec3::Zero(), 0.04};
    around.workspace.add_body(ball);
    Teleoperation bench(link, around);
    bench.engage();
    const auto room = [&] {
      return ball.wall_at(bench.commanded.position).clearance(bench.commanded.position);
    };
    bench.move(Vec3(0.002, 0.0, 0.06), 1.0);
    bench.run(0.5);
    ASSERT_EQ(bench.state(), engaged);
    EXPECT_LE(room(), 1e-3) << link;
    EXPECT_LE(bench.force(), -1.0) << "it is felt";
    // The hand moves sideways and onwards while it presses upwards.
    double least = 1.0;
    for (int i = 0; i < 100; ++i) {
      bench.move(Vec3(1e-3, 0.0, 1.5e-3), 0.02);
      least = std::min(least, room());
    }
    EXPECT_GE(least, -1e-9);
    EXPECT_GE(bench.commanded.position.z(), 0.13) << link << ": it has come past the ball";
    EXPECT_LE(bench.made(), 0.0);
  }
}

/// If a server sends false walls, the commands must stay finite and give the hand no energy.
TEST(TeleoperationWalls, WallsThatAreNoneGiveTheHandNoEnergy) {
  Teleoperation bench("delay=0", seat());
  test::Random random(9);
  bench.engage();
  bench.change_reply = [&](Reply& reply) {
    if (!reply.remote) return;
    reply.remote->wall_count = 1 + static_cast<int>(random.uniform(0.0, 2.99));
    for (RemoteWall& w : reply.remote->walls)
      w = {{random.direction(), random.uniform(-0.5, 0.5)},
           std::pow(10.0, random.uniform(0.0, 9.0)),
           random.uniform(1e-4, 0.1),
           static_cast<std::uint32_t>(random.uniform(0.0, 3.0))};
  };
  for (int i = 0; i < 20; ++i) bench.move(0.02 * random.direction(), 0.2);
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_TRUE(bench.servo.held().finite());
  EXPECT_GT(bench.servo.statistics().max_force, 0.5);
}

TEST(TeleoperationWalls, ARobotWithoutRoomInCommonIsRefused) {
  Teleoperation bench("delay=0", seat());
  bench.server->answer(control::LeaveRequest{Teleoperation::kRobot}, 0, {}, bench.now);
  control::JoinRequest request{"tester", "empty", bench.hand.spec(), bench.parameters,
                               Role::follower};
  request.workspace.add({Vec3::UnitZ(), kTop - kDepth});
  const auto join = [&](std::uint64_t id) {
    return bench.server->answer(request, id, test::keys(id), bench.now);
  };
  const auto answer = join(0x900);
  const auto* refused = std::get_if<control::Refused>(&answer);
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->code, control::RefusalCode::bad_parameters);
  EXPECT_EQ(refused->reason,
            "the robot's own workspace and that of scene 'empty' leave no place that is in both; "
            "widen one of them, or leave one out");
  request.workspace.walls[0].distance = 0.0;
  const auto let_in = join(0x901);
  const auto* accepted = std::get_if<control::JoinAccepted>(&let_in);
  ASSERT_NE(accepted, nullptr);
  EXPECT_EQ(accepted->workspace.count, 6u) << "it is told those of its seat";
}

}  // namespace
}  // namespace feltwire::teleoperation_walls_test
