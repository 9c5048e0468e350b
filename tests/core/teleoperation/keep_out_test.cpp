// A robot's target must not enter keep-out bodies. Tests closed forms of the distance to these
// bodies, and invariants for random bodies, rooms and paths.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/teleoperation/clutch_offset.hpp"
#include "core/teleoperation/workspace.hpp"
#include "tests/core/support.hpp"

namespace feltwire::keep_out_test {
namespace {

constexpr double kRounding = 1e-9;  // [m]

double distance(const KeepOutBody& body, const Vec3& point) {
  return body.wall_at(point).clearance(point);
}

Quaternion any_turn(test::Random& random) {
  return Quaternion(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.direction()));
}

KeepOutBody any_body(test::Random& random) {
  const Vec3 half(random.uniform(0.0, 0.08), random.uniform(0.0, 0.08), random.uniform(0.0, 0.08));
  return {{random.uniform(0.0, 0.2) * random.direction(), any_turn(random)},
          random.chance(0.3) ? Vec3(Vec3::Zero()) : half,
          random.uniform(KeepOutBody::kLeastRadius, 0.05)};
}

TEST(KeepOutBody, DistancesInClosedForm) {
  const KeepOutBody ball{{Vec3(0.1, 0.2, 0.3), Quaternion::Identity()}, Vec3::Zero(), 0.05};
  EXPECT_NEAR(distance(ball, Vec3(0.1, 0.2, 0.4)), 0.05, kRounding);
  EXPECT_NEAR(distance(ball, Vec3(0.1, 0.2, 0.3)), -0.05, kRounding) << "its middle";
  // A capsule along x, rotated to the vertical.
  const KeepOutBody capsule{
      {Vec3::Zero(), Quaternion(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()))},
      Vec3(0.1, 0.0, 0.0),
      0.02};
  EXPECT_NEAR(distance(capsule, Vec3(0.0, 0.0, 0.2)), 0.08, kRounding);
  EXPECT_NEAR(distance(capsule, Vec3(0.03, 0.04, 0.05)), 0.03, kRounding);
  // A box with round edges. The points are over a face, off an edge, off a corner and inside.
  const KeepOutBody box{{}, Vec3(0.1, 0.2, 0.3), 0.01};
  EXPECT_NEAR(distance(box, Vec3(0.05, 0.1, 0.4)), 0.09, kRounding);
  EXPECT_NEAR(distance(box, Vec3(0.13, -0.24, 0.1)), 0.04, kRounding);
  EXPECT_NEAR(distance(box, Vec3(-0.12, -0.22, 0.31)), 0.02, kRounding);
  EXPECT_NEAR(distance(box, Vec3(0.07, 0.0, 0.1)), -0.04, kRounding);
  EXPECT_EQ(box.wall_at(Vec3(-0.07, 0.0, 0.1)).normal, -Vec3::UnitX());
}

/// All other properties need f(x) >= f(p) + n . (x - p), with the gradient n.
TEST(KeepOutBody, TheDistanceIsConvex) {
  test::Random random(3);
  for (int run = 0; run < 20'000; ++run) {
    const KeepOutBody body = any_body(random);
    const auto place = [&] {
      return Vec3(body.pose.position + random.uniform(0.0, 0.2) * random.direction());
    };
    const Vec3 p = place(), x = place();
    const WorkspaceWall wall = body.wall_at(p);
    ASSERT_NEAR(wall.normal.norm(), 1.0, 1e-12);
    ASSERT_GE(distance(body, x), wall.clearance(x) - 1e-12);
    const Vec3 near = p + 1e-7 * random.direction();
    ASSERT_NEAR(distance(body, near), wall.clearance(near), 2e-8) << "a subgradient is near";
  }
}

Workspace any_workspace(test::Random& random) {
  Workspace workspace;
  if (random.chance(0.5)) workspace.add_box(Vec3::Constant(-0.25), Vec3::Constant(0.25));
  const int bodies = 1 + static_cast<int>(random.uniform(0.0, 7.99));
  for (int i = 0; i < bodies; ++i) workspace.add_body(any_body(random));
  return workspace;
}

/// The target must stay outside for any start, even inside a body, and for any wanted position,
/// even beyond all bodies.
TEST(KeepOutBodies, TheTargetNeverEntersOneNorCrossesIt) {
  test::Random random(7);
  int touched = 0;
  for (int run = 0; run < 150; ++run) {
    Workspace workspace = any_workspace(random);
    if (run % 3 == 1) workspace.locked = {false, true, false};
    if (run % 3 == 2) workspace.locked = {true, false, true};
    WorkspaceLimit limit(workspace);
    const Pose begun{random.uniform(0.0, 0.2) * random.direction(), Quaternion::Identity()};
    limit.begin(begun);
    ASSERT_EQ(limit.keep(begun).position, begun.position) << "the first step is zero, exactly";
    std::vector<double> deepest;
    for (const KeepOutBody& body : workspace.keep_out())
      deepest.push_back(std::min(0.0, distance(body, begun.position)));
    Pose wanted = begun;
    Vec3 before = begun.position;
    for (int i = 0; i < 200; ++i) {
      wanted.position = before + random.uniform(0.0, 0.02) * random.direction();
      if (i % 20 == 7) wanted.position = random.uniform(0.0, 0.5) * random.direction();
      const Vec3 kept = limit.keep(wanted).position;
      Vec3 meant = wanted.position;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        if (!workspace.locked[static_cast<std::size_t>(axis)]) continue;
        ASSERT_EQ(kept[axis], begun.position[axis]) << "exactly";
        meant[axis] = begun.position[axis];
      }
      ASSERT_LE((kept - meant).norm(), (before - meant).norm() + kRounding) << "not away from it";
      for (std::size_t n = 0; n < workspace.body_count; ++n) {
        const double now = distance(workspace.bodies[n], kept);
        ASSERT_GE(now, deepest[n] - kRounding) << run << ", " << i;
        deepest[n] = std::min(0.0, std::max(deepest[n], now));
        touched += now < 1e-6 ? 1 : 0;
      }
      before = kept;
    }
  }
  EXPECT_GE(touched, 1000) << "the bodies were met";
}

/// A plate is thinner than a step. The target must stay on its side, for any wanted position.
TEST(KeepOutBodies, AThinPlateIsNotCrossed) {
  Workspace workspace;
  workspace.add_body({{}, Vec3(1.0, 1.0, 0.0), KeepOutBody::kLeastRadius});
  WorkspaceLimit limit(workspace);
  limit.begin({Vec3(0.0, 0.0, 0.1), Quaternion::Identity()});
  for (const double z : {-0.05, -0.5, 0.02, -0.9}) {
    const Vec3 kept = limit.keep({Vec3(0.2, 0.1, z), Quaternion::Identity()}).position;
    EXPECT_LE((kept - Vec3(0.2, 0.1, std::max(z, KeepOutBody::kLeastRadius))).norm(), kRounding);
  }
}

/// A hand pushes against a ball and moves sideways. The target must slide around the ball, as with
/// a clutch offset that follows the target. The target must never move farther than the hand.
TEST(KeepOutBodies, AHandSlidesAroundABall) {
  const KeepOutBody ball{{}, Vec3::Zero(), 0.1};
  Workspace workspace;
  workspace.add_body(ball);
  WorkspaceLimit limit(workspace);
  Vec3 target(-0.02, 0.0, 0.15);
  limit.begin({target, Quaternion::Identity()});
  const Vec3 step(2e-4, 0.0, -2e-4);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 before = target;
    target = limit.keep({target + step, Quaternion::Identity()}).position;
    ASSERT_LE((target - before).norm(), step.norm() + kRounding);
    ASSERT_GE(target.norm(), 0.1 - kRounding);
  }
  EXPECT_GE(target.x(), 0.1) << "it has come past it";
  EXPECT_LE(target.z(), 0.0);
}

/// The target must reach a free position on the far side of a ball in one step.
TEST(KeepOutBodies, AWishBesideABodyIsReachedAtOnce) {
  Workspace workspace;
  workspace.add_body(KeepOutBody{{}, Vec3::Zero(), 0.1});
  WorkspaceLimit limit(workspace);
  limit.begin({Vec3(0.0, 0.0, 0.15), Quaternion::Identity()});
  const Vec3 wanted(0.14, 0.0, 0.0);
  EXPECT_LE((limit.keep({wanted, Quaternion::Identity()}).position - wanted).norm(), kRounding);
}

/// Steps below the rounding limit must not add up.
TEST(KeepOutBodies, NoSmallStepsLeadIn) {
  Workspace workspace;
  workspace.add_body(KeepOutBody{{}, Vec3::Zero(), 0.1});
  WorkspaceLimit limit(workspace);
  Vec3 target(0.0, 0.0, 0.1);
  limit.begin({target, Quaternion::Identity()});
  for (int i = 0; i < 100'000; ++i)
    target = limit.keep({target - Vec3(0.0, 0.0, 0.9e-12), Quaternion::Identity()}).position;
  EXPECT_GE(target.z(), 0.1 - 1e-11);
}

TEST(KeepOutBodies, TheHandIsToldTheWallOfEach) {
  Workspace workspace;
  workspace.add({Vec3::UnitZ(), -0.1});
  workspace.add_body({{}, Vec3::Zero(), 0.05});
  WorkspaceLimit limit(workspace);
  limit.begin({Vec3(0.1, 0.0, 0.0), Quaternion::Identity()});
  ASSERT_EQ(limit.walls().size(), 2u);
  EXPECT_EQ(limit.walls()[1].normal, Vec3::UnitX());
  EXPECT_NEAR(limit.walls()[1].distance, 0.05, kRounding);
  limit.keep({Vec3(0.0, 0.0, 0.1), Quaternion::Identity()});
  ASSERT_EQ(limit.walls().size(), 2u);
  EXPECT_NEAR(limit.walls()[1].distance, 0.05, kRounding);
  EXPECT_LE((limit.walls()[1].normal - limit.keep({}).position.normalized()).norm(), 0.3);
  // The locked axes keep the target above the body.
  workspace.locked = {false, false, true};
  limit = WorkspaceLimit(workspace);
  limit.begin({Vec3(0.0, 0.0, 0.2), Quaternion::Identity()});
  ASSERT_EQ(limit.walls().size(), 1u) << "nor is the wall";
  EXPECT_GE(limit.walls()[0].clearance(Vec3(0.0, 0.0, 0.2)), 1e3);
  EXPECT_EQ(limit.keep({Vec3(0.5, 0.1, 0.0), Quaternion::Identity()}).position,
            Vec3(0.5, 0.1, 0.2));
}

/// The aim of a follower ignores the bodies. The follower's own limit keeps the robot out of the
/// bodies.
TEST(KeepOutBodies, AnAimLooksPastThemAndChangesNothing) {
  Workspace workspace;
  workspace.add_box(Vec3::Constant(-1.0), Vec3::Constant(1.0));
  workspace.add_body({{}, Vec3::Zero(), 0.1});
  WorkspaceLimit limit(workspace);
  limit.begin({Vec3(-0.5, 0.0, 0.0), Quaternion::Identity()});
  EXPECT_EQ(limit.aim({Vec3(0.0, 3.0, 0.0), Quaternion::Identity()}).position, Vec3(0, 1, 0));
  EXPECT_EQ(limit.aim({Vec3(0.5, 0.0, 0.0), Quaternion::Identity()}).position, Vec3(0.5, 0, 0));
  EXPECT_LE(
      (limit.keep({Vec3(0.5, 0.0, 0.0), Quaternion::Identity()}).position - Vec3(-0.1, 0.0, 0.0))
          .norm(),
      kRounding);
}

TEST(KeepOutBodies, SayWhereTheyLeaveNoRoom) {
  Workspace room;
  room.add_box(Vec3::Constant(-0.1), Vec3::Constant(0.1));
  EXPECT_TRUE(has_room(room, 0.005));
  room.add_body({{}, Vec3::Zero(), 0.12});
  EXPECT_TRUE(has_room(room, 0.005)) << "in its corners";
  EXPECT_FALSE(has_room(room, 0.05));
  room.add_body({{}, Vec3::Constant(0.1), 0.01});
  EXPECT_FALSE(has_room(room, 0.005));
  Workspace anywhere;
  anywhere.add_body({{}, Vec3::Constant(10.0), 1.0});
  EXPECT_TRUE(has_room(anywhere, 0.1));
}

}  // namespace
}  // namespace feltwire::keep_out_test
