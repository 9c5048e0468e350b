// Tests a remote robot's workspace. The target must stay inside, and the hand must get the walls.

#include <gtest/gtest.h>

#include <random>

#include "tests/server/scene/teleop_link_bench.hpp"

namespace feltwire::teleop_link_test {
namespace {

using enum LinkState;

RemoteSeat walled_seat(double scale = 1.0) {
  RemoteSeat seat;
  seat.scale = scale;
  seat.speed = 10.0;
  seat.workspace.add_box(Vec3(0.3, 0.0, 0.2), Vec3(0.5, 0.2, 0.4));
  return seat;
}

TEST(RemoteWalls, TheTargetStaysInTheWorkspaceForAnyHand) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> step(0.0, 2e-3);
  for (const double scale : {0.3, 1.0, 4.0}) {
    Bench bench(walled_seat(scale));
    bench.press(bench.anna);
    for (int i = 0; i < 5000; ++i) {
      bench.anna.at += Vec3(step(random), step(random), step(random));
      // The hand ignores the walls, and sometimes reports a false offset.
      if (i % 1000 == 500) bench.anna.offset = 100.0 * Vec3::Random();
      bench.send(bench.anna);
      ASSERT_EQ(bench.target.state, engaged);
      const Vec3& at = bench.target.pose.position;
      ASSERT_TRUE((at.array() >= Eigen::Array3d(0.3, 0.0, 0.2) - 1e-9).all() &&
                  (at.array() <= Eigen::Array3d(0.5, 0.2, 0.4) + 1e-9).all())
          << at.transpose();
    }
  }
}

TEST(RemoteWalls, AHandThatComesBackFromAWallMovesTheRobotAtOnce) {
  Bench bench(walled_seat());
  bench.press(bench.anna);
  for (int i = 0; i < 300; ++i) {
    bench.anna.at.x() += 1e-3;
    bench.send(bench.anna);
  }
  EXPECT_NEAR(bench.target.pose.position.x(), 0.5, 1e-12);
  for (int i = 1; i <= 20; ++i) {
    bench.anna.at.x() -= 1e-3;
    bench.send(bench.anna);
    ASSERT_NEAR(bench.target.pose.position.x(), 0.5 - 1e-3 * i, 1e-12);
  }
}

TEST(RemoteWalls, TellsTheNearestWallsWhereTheHandMeetsThem) {
  Bench bench(walled_seat(2.0));
  bench.send(bench.anna);
  EXPECT_EQ(bench.link.reply_for(bench.anna.number, bench.now).wall_count, 0)
      << "only while engaged";
  bench.press(bench.anna);
  const Vec3 began = bench.anna.at;
  for (int i = 0; i < 10; ++i) {
    bench.anna.at += Vec3(3e-3, -2e-3, 1e-3);  // 20 times as far for the robot: 60, -40, 20 mm
    bench.send(bench.anna);
  }
  const Remote told = bench.link.reply_for(bench.anna.number, bench.now);
  ASSERT_EQ(told.wall_count, 3);
  // The robot is at (0.46, 0.06, 0.32) in the box: 40 mm to x = 0.5, 60 mm to y = 0, 80 mm to z =
  // 0.4.
  const Vec3 normals[] = {-Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ()};
  const double away[] = {0.02, 0.03, 0.04};  // [m] in the scale of the hand
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(told.walls[i].wall.normal, normals[i]);
    EXPECT_NEAR(told.walls[i].wall.clearance(bench.anna.at), away[i], 1e-12);
    EXPECT_EQ(told.walls[i].stiffness, 1000.0);
    EXPECT_EQ(told.walls[i].depth, 5e-3);
  }
  EXPECT_NEAR(told.walls[0].wall.clearance(began), 0.05, 1e-12);
}

TEST(RemoteWalls, ATargetThatIsOutsideComesBackAndIsNotPulled) {
  Bench bench(walled_seat());
  bench.state.commanded.position.x() = 0.6;
  bench.press(bench.anna);
  EXPECT_EQ(bench.target.pose.position, Vec3(0.6, 0.1, 0.3)) << "exactly: nothing is pulled in";
  const auto move = [&](double x) {
    bench.anna.at.x() += x;
    bench.send(bench.anna);
    return bench.target.pose.position.x();
  };
  EXPECT_NEAR(move(0.01), 0.6, 1e-12) << "no farther out";
  EXPECT_NEAR(move(-0.02), 0.58, 1e-12);
  EXPECT_NEAR(move(0.01), 0.58, 1e-12) << "nor out again";
  for (int i = 0; i < 10; ++i) move(-0.01);
  EXPECT_NEAR(move(0.0), 0.48, 1e-12);
  for (int i = 0; i < 10; ++i) move(0.01);
  EXPECT_NEAR(move(0.0), 0.5, 1e-12) << "now the wall is where it is meant";
}

TEST(RemoteWalls, LockedAxesKeepTheValueOfEachEngagement) {
  RemoteSeat seat;
  seat.speed = 10.0;
  seat.workspace.locked = {false, true, false};
  Workspace own;
  own.turning_locked = true;  // The robot's own lock, in addition to the scene's
  Bench bench(seat, own);
  bench.press(bench.anna);
  for (int i = 0; i < 50; ++i) {
    bench.anna.at += Vec3(1e-3, 2e-3, -1e-3);
    bench.anna.turn = Quaternion(Eigen::AngleAxisd(0.01 * i, Vec3::UnitX()));
    bench.send(bench.anna);
    ASSERT_EQ(bench.target.pose.position.y(), 0.1) << "exactly";
    ASSERT_EQ(bench.target.pose.orientation.coeffs(), Quaternion::Identity().coeffs());
  }
  EXPECT_NEAR(bench.target.pose.position.x(), 0.45, 1e-12);
  EXPECT_NEAR(bench.target.pose.position.z(), 0.25, 1e-12);
  bench.state.commanded.position.y() = 0.15;  // A person moved the robot.
  bench.press(bench.anna);
  bench.anna.at.y() += 0.01;
  bench.send(bench.anna);
  EXPECT_EQ(bench.target.pose.position.y(), 0.15);
}

TEST(RemoteWalls, TheTighterOfTwoWorkspacesHolds) {
  Workspace own;
  own.add_box(Vec3(0.0, 0.05, 0.0), Vec3(0.42, 1.0, 1.0));
  Bench bench(walled_seat(), own);
  bench.press(bench.anna);
  for (int i = 0; i < 200; ++i) {
    bench.anna.at += Vec3(1e-3, -1e-3, 1e-3);
    bench.send(bench.anna);
  }
  EXPECT_LE((bench.target.pose.position - Vec3(0.42, 0.05, 0.4)).norm(), 1e-9);
}

}  // namespace
}  // namespace feltwire::teleop_link_test
