// Tests walls and locked axes: closed forms for boxes, and invariants for any room and path.

#include "core/teleoperation/workspace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/teleoperation/clutch_offset.hpp"

namespace feltwire::workspace_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-9;  // [m]

class Dice {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3 vector(double most) {
    return {between(-most, most), between(-most, most), between(-most, most)};
  }
  Vec3 direction() {
    Vec3 v = vector(1.0);
    while (v.norm() < 0.1) v = vector(1.0);
    return v.normalized();
  }

 private:
  std::mt19937_64 random_{11};
};

Workspace box(const Vec3& low, const Vec3& high) {
  Workspace workspace;
  workspace.add_box(low, high);
  return workspace;
}

/// Returns walls around the origin. The origin is in front of all of them.
Workspace any_room(Dice& dice) {
  Workspace room;
  const int walls = static_cast<int>(dice.between(1.0, 16.0));
  for (int i = 0; i < walls; ++i) room.add({dice.direction(), -dice.between(0.01, 0.3)});
  return room;
}

TEST(Workspace, ABoxClampsEachAxis) {
  Dice dice;
  const Vec3 low(-0.1, -0.2, 0.0), high(0.3, 0.1, 0.05);
  const Workspace room = box(low, high);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point = dice.vector(1.0);
    EXPECT_LE((nearest_in_front(point, room.view()) - point.cwiseMax(low).cwiseMin(high)).norm(),
              kRounding);
  }
  const Vec3 inside(0.1, 0.0, 0.02);
  EXPECT_EQ(nearest_in_front(inside, room.view()), inside) << "exactly";
}

double farthest_behind(const Vec3& point, const Workspace& room) {
  double behind = 0.0;
  for (const WorkspaceWall& w : room.view()) behind = std::max(behind, -w.clearance(point));
  return behind;
}

TEST(Workspace, ThePointInFrontIsTheNearest) {
  Dice dice;
  int nearest = 0;
  for (int i = 0; i < 300; ++i) {
    const Workspace room = any_room(dice);
    const Vec3 point = dice.vector(1.0), found = nearest_in_front(point, room.view());
    if (farthest_behind(found, room) > kRounding) continue;
    // The room is convex. No position in the room may be beyond the plane through the found point.
    double beyond = 0.0;
    for (int n = 0; n < 50; ++n) {
      const Vec3 other = nearest_in_front(dice.vector(0.5), room.view());
      if (farthest_behind(other, room) <= kRounding)
        beyond = std::max(beyond, (point - found).dot(other - found));
    }
    nearest += beyond <= 1e-7 ? 1 : 0;
  }
  EXPECT_GE(nearest, 250) << "acute wedges aside, where WorkspaceLimit has the last word";
}

TEST(Workspace, TheTargetNeverLeavesTheRoomAndNeverJumps) {
  Dice dice;
  for (int run = 0; run < 200; ++run) {
    const Workspace room = any_room(dice);
    WorkspaceLimit limit(room);
    const Pose begun{dice.vector(0.2), Quaternion::Identity()};
    limit.begin(begun);
    EXPECT_EQ(limit.keep(begun).position, begun.position) << "the first step is zero, exactly";
    std::vector<double> behind;
    for (const WorkspaceWall& w : room.view())
      behind.push_back(std::max(0.0, -w.clearance(begun.position)));
    Pose wanted = begun;
    for (int i = 0; i < 200; ++i) {
      wanted.position += dice.vector(0.02);
      if (i % 50 == 7) wanted.position = dice.vector(1e3);  // The next jump leads back.
      const Vec3 kept = limit.keep(wanted).position;
      for (std::size_t n = 0; n < room.count; ++n) {
        const double now = -room.walls[n].clearance(kept);
        ASSERT_LE(now, behind[n] + kRounding) << "farther behind a wall than it was";
        behind[n] = std::min(behind[n], std::max(0.0, now));
      }
    }
  }
}

TEST(Workspace, WhatIsNotFiniteChangesNothing) {
  WorkspaceLimit limit(box(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  limit.begin({Vec3(0.5, 0.0, 0.0), Quaternion::Identity()});
  const Vec3 kept = limit.keep({Vec3(2.0, 0.0, 0.0), Quaternion::Identity()}).position;
  EXPECT_EQ(kept, Vec3(1.0, 0.0, 0.0));
  EXPECT_EQ(limit.keep({Vec3(kNan, 0.0, 0.0), Quaternion::Identity()}).position, kept);
  Quaternion none;
  none.coeffs().setConstant(kNan);
  EXPECT_EQ(limit.keep({Vec3::Zero(), none}).position, kept);
}

TEST(Workspace, ALockedAxisKeepsItsValueAndWallsHoldOnTheOthers) {
  Dice dice;
  for (int run = 0; run < 200; ++run) {
    Workspace room = any_room(dice);
    for (bool& locked : room.locked) locked = dice.between(0.0, 1.0) < 0.4;
    room.turning_locked = run % 2 == 0;
    WorkspaceLimit limit(room);
    const Pose begun{0.01 * dice.direction(), Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitY()))};
    limit.begin(begun);
    for (int i = 0; i < 100; ++i) {
      const Pose wanted{dice.vector(0.6),
                        Quaternion(Eigen::AngleAxisd(dice.between(-1, 1), dice.direction()))};
      const Pose kept = limit.keep(wanted);
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        if (room.locked[static_cast<std::size_t>(axis)]) {
          ASSERT_EQ(kept.position[axis], begun.position[axis]) << "exactly";
        }
      for (const WorkspaceWall& w : room.view()) {
        Vec3 along = w.normal;
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          if (room.locked[static_cast<std::size_t>(axis)]) along[axis] = 0.0;
        if (along.norm() >= 0.1) {
          ASSERT_GE(w.clearance(kept.position), -kRounding);
        }
      }
      const Quaternion& turned = room.turning_locked ? begun.orientation : wanted.orientation;
      ASSERT_EQ(kept.orientation.coeffs(), turned.coeffs());
    }
  }
}

/// A hand moves 100 mm beyond a wall. The first millimetre back must already move the target.
TEST(Workspace, AnIndexThatMovesWithTheClampHasNoRatchet) {
  for (const double scale : {0.2, 1.0, 5.0}) {
    WorkspaceLimit limit(box(Vec3(-1, -1, -1), Vec3(1, 1, 0.1)));
    ClutchOffset index(scale);
    Pose hand{Vec3(3.0, 2.0, 1.0), Quaternion::Identity()};
    Pose target{Vec3(0.5, 0.0, 0.0), Quaternion::Identity()};
    index.engage(hand, target);
    limit.begin(target);
    const auto move = [&](double up) {
      hand.position.z() += up;
      const Pose asked = index.target(hand);
      target = limit.keep(asked);
      index.shift(limit.free_part(target.position - asked.position));
    };
    for (int i = 0; i < 100; ++i) move((0.1 / scale + 0.1) / 100.0);
    EXPECT_NEAR(target.position.z(), 0.1, kRounding);
    // The wall is now at the hand. Each millimetre back must move the target.
    const WorkspaceWall& top = limit.walls()[5];
    EXPECT_NEAR(index.at_hand(top).clearance(hand.position), 0.0, kRounding);
    for (int i = 1; i <= 10; ++i) {
      move(-1e-3);
      ASSERT_NEAR(target.position.z(), 0.1 - scale * 1e-3 * i, kRounding);
      ASSERT_NEAR(index.at_hand(top).clearance(hand.position), 1e-3 * i, kRounding);
    }
  }
}

/// Only the free axes change the height above a surface. Only these axes get the force of the
/// surface.
TEST(Workspace, AContactOfALockedRobotIsSeenAlongItsFreeAxes) {
  Dice dice;
  for (int run = 0; run < 200; ++run) {
    Workspace lock;
    lock.locked = {false, run % 2 == 0, true};
    WorkspaceLimit limit(lock);
    const Pose begun{dice.vector(0.2), Quaternion::Identity()};
    limit.begin(begun);
    const RemoteContact contact{.surface = 3,
                                .touching = true,
                                .point = begun.position + dice.vector(0.02),
                                .normal = dice.direction(),
                                .stiffness = 700.0,
                                .friction = 0.2,
                                .velocity = Vec3::Zero()};
    const RemoteContact seen = limit.free_part(contact);
    const double part = limit.free_part(contact.normal).norm();
    if (part < 0.1) {
      EXPECT_EQ(seen.surface, 0u);
      continue;
    }
    ASSERT_EQ(seen.surface, 3u);
    for (int i = 0; i < 10; ++i) {
      const Vec3 robot = begun.position + limit.free_part(dice.vector(0.05));
      const Vec3 hand =
          robot + (Vec3::Ones() - limit.free_part(Vec3::Ones())) * dice.between(-1, 1);
      const double height = (robot - contact.point).dot(contact.normal);
      const Vec3 push = -contact.stiffness * height * limit.free_part(contact.normal);
      const Vec3 felt = -seen.stiffness * (hand - seen.point).dot(seen.normal) * seen.normal;
      EXPECT_LE((felt - push).norm(), 1e-9) << "wherever the hand is along the locked axes";
    }
  }
}

TEST(Workspace, SaysWhereThereIsNoRoom) {
  const Workspace room = box(Vec3(0, 0, 0), Vec3(1, 1, 0.01));
  EXPECT_TRUE(has_room(room, 0.004));
  EXPECT_FALSE(has_room(room, 0.006));
  EXPECT_FALSE(has_room(joined(room, box(Vec3(0, 0, 0.02), Vec3(1, 1, 1))), 0.0));
  EXPECT_TRUE(has_room(joined(room, box(Vec3(0.5, 0.5, -1), Vec3(2, 2, 1))), 0.004));
  EXPECT_TRUE(has_room({}, 0.1));
}

}  // namespace
}  // namespace feltwire::workspace_test
