// Tests the surface estimate from a robot's wrench, the leader's contact with this surface, and the
// limits of targets.

#include "core/teleoperation/contact_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/teleoperation/surface_offset.hpp"
#include "core/teleoperation/target_limiter.hpp"

namespace feltwire::contact_estimator_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A wall with spring and damper and the normal n. The tip enters along -n.
struct Wall {
  Vec3 normal = Vec3::UnitZ();
  double stiffness = 2000.0, damping = 0.0, place = 0.0;  // [m] `place` is along n
  Vec3 force(const Vec3& tip, const Vec3& velocity) const {
    const double depth = place - tip.dot(normal);
    if (!(depth > 0.0)) return Vec3::Zero();
    return std::max(0.0, stiffness * depth - damping * velocity.dot(normal)) * normal;
  }
};

/// Moves from 2 mm in front of the wall to `depth` within `time`, and stays for the same time.
const RemoteContact& press(ContactEstimator& estimate, const Wall& wall, double depth,
                           double time) {
  const int steps = static_cast<int>(time / kPeriod);
  double before = 2e-3;
  for (int n = 0; n <= 2 * steps; ++n) {
    const double u = std::min(1.0, static_cast<double>(n) / steps);
    const double now = 2e-3 - (depth + 2e-3) * u * u * (3.0 - 2.0 * u);
    const Vec3 tip = (wall.place + now) * wall.normal;
    const Vec3 velocity = (now - before) / kPeriod * wall.normal;
    estimate.step({tip, velocity, wall.force(tip, velocity), kPeriod});
    before = now;
  }
  return estimate.contact();
}

TEST(ContactEstimator, FindsPlaceNormalAndStiffnessOfASpringInEveryDirection) {
  for (const double stiffness : {300.0, 2000.0, 20000.0})
    for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(Vec3(1, 2, -2) / 3.0)}) {
      ContactEstimator estimate({});
      const Wall wall{.normal = normal, .stiffness = stiffness, .place = 0.1};
      const RemoteContact& seen = press(estimate, wall, 4e-3, 0.2);
      EXPECT_EQ(seen.surface, 1u);
      EXPECT_TRUE(seen.touching);
      EXPECT_NEAR(seen.stiffness, stiffness, 1e-3 * stiffness);
      EXPECT_NEAR(seen.point.dot(normal), 0.1, 1e-6);
      EXPECT_NEAR((seen.normal - normal).norm(), 0.0, 1e-9);
      EXPECT_TRUE(seen.velocity.isZero(1e-12));
    }
}

TEST(ContactEstimator, ADamperOfTheWallIsNotTakenForStiffness) {
  ContactEstimator estimate({});
  const RemoteContact& seen = press(estimate, {.damping = 20.0}, 4e-3, 0.1);
  EXPECT_NEAR(seen.stiffness, 2000.0, 40.0);
}

TEST(ContactEstimator, ASurfaceThatIsNotThereRecedesAndIsForgotten) {
  ContactEstimator estimate({});
  press(estimate, {}, 4e-3, 0.2);
  Vec3 tip = Vec3::Zero();
  for (int n = 0; n < 100; ++n) {
    tip.z() -= 1e-4;
    estimate.step({tip, Vec3(0, 0, -0.1), Vec3::Zero(), kPeriod});
    const bool waits = (n + 1) * kPeriod < ContactEstimator::kApart - 1e-9;
    EXPECT_EQ(estimate.contact().touching, waits) << n;
    if (!waits) {
      EXPECT_LE(estimate.contact().point.z(), tip.z() + 1e-12);
    }
  }
  EXPECT_EQ(estimate.contact().surface, 1u);
  for (int n = 0; n < 200; ++n) {
    tip.z() -= 1e-4;
    estimate.step({tip, Vec3(0, 0, -0.1), Vec3::Zero(), kPeriod});
  }
  EXPECT_EQ(estimate.contact().surface, 0u);
}

TEST(ContactEstimator, AWallThatMovesHasItsSpeed) {
  ContactEstimator estimate({});
  Wall wall;
  press(estimate, wall, 4e-3, 0.4);  // The estimator learns the stiffness in the first half second.
  for (int n = 0; n < 1000; ++n) {
    wall.place += 0.02 * kPeriod;
    const Vec3 tip(0, 0, wall.place - 4e-3);
    estimate.step({tip, Vec3(0, 0, 0.02), wall.force(tip, Vec3::Zero()), kPeriod});
  }
  EXPECT_NEAR(estimate.contact().velocity.z(), 0.02, 1e-4);
  EXPECT_NEAR(estimate.contact().stiffness, 2000.0, 2.0);
}

TEST(ContactEstimator, SlidingShowsFrictionAndKeepsTheNormal) {
  ContactEstimator estimate({});
  press(estimate, {}, 4e-3, 0.2);
  for (int n = 0; n < 500; ++n)
    estimate.step(
        {Vec3(0.05 * n * kPeriod, 0, -4e-3), Vec3(0.05, 0, 0), Vec3(-2.4, 0, 8), kPeriod});
  EXPECT_NEAR(estimate.contact().friction, 0.3, 0.01);
  EXPECT_NEAR(estimate.contact().normal.z(), 1.0, 1e-6);
}

/// A tool sticks to a ball and slips around it. The estimated surface must stay at rest while the
/// normal rotates.
TEST(ContactEstimator, ACurvedSurfaceUnderAToolThatSlipsStands) {
  constexpr double kRadius = 0.1, kDepth = 2e-3, kFriction = 0.3;
  constexpr double kSlips = 0.2;               // [m/s]
  constexpr int kSlipTime = 20, kEvery = 150;  // [ms]
  ContactEstimator estimate({});
  const Wall top{.place = kRadius};
  press(estimate, top, kDepth, 0.3);
  double fastest = 0.0, farthest = 0.0, most_turned = 0.0, angle = 0.0;
  for (int n = 1; n <= 1500; ++n) {
    const double speed = n % kEvery < kSlipTime ? kSlips : 0.0;
    angle += speed / kRadius * kPeriod;
    const Vec3 out(std::sin(angle), 0.0, std::cos(angle)), way(out.z(), 0.0, -out.x());
    const Vec3 tip = (kRadius - kDepth) * out;
    const double pushes = top.stiffness * kDepth;
    const RemoteContact& seen =
        estimate.step({tip, speed * way, pushes * (out - kFriction * way), kPeriod});
    fastest = std::max(fastest, seen.velocity.norm());
    farthest = std::max(farthest, std::abs((seen.point - tip).norm() - kDepth));
    most_turned = std::max(most_turned, std::acos(std::min(1.0, seen.normal.dot(out))));
  }
  EXPECT_LE(fastest, 5e-3) << "[m/s] 0.036 if its slips were taken for a motion of the surface";
  EXPECT_LE(farthest, 0.5e-3) << "[m]";
  EXPECT_LE(most_turned, std::atan(kFriction) + 1e-3) << "[rad] friction leans it where it sticks";
}

TEST(ContactEstimator, FrictionOfATouchThatArrivesDoesNotTurnTheNormal) {
  ContactEstimator estimate({});
  for (int n = 0; n < 110; ++n) estimate.step({Vec3::Zero(), Vec3::Zero(), Vec3(0, 0, 8), kPeriod});
  // The tool moves in and slides slightly. Friction tilts the force by atan(0.3).
  for (int n = 0; n < 300; ++n)
    estimate.step({Vec3::Zero(), Vec3(0.005, 0, -0.02), Vec3(-2.4, 0, 8), kPeriod});
  EXPECT_NEAR(estimate.contact().normal.z(), 1.0, 1e-6);
}

TEST(ContactEstimator, ATouchThatBouncesIsOneTouch) {
  ContactEstimator estimate({});
  const Wall wall;
  double before = -1e-4;
  for (int bounce = 0; bounce < 4; ++bounce)
    for (const double depth : {0.2e-3, 0.6e-3, 0.4e-3, 0.15e-3, -0.1e-3, -0.1e-3}) {
      const Vec3 tip(0, 0, -depth), velocity(0, 0, (before - depth) / kPeriod);
      estimate.step({tip, velocity, wall.force(tip, velocity), kPeriod});
      before = depth;
    }
  EXPECT_EQ(estimate.contact().surface, 1u);
  EXPECT_NEAR(estimate.contact().stiffness, wall.stiffness, 1.0);
}

TEST(ContactEstimator, AToolThatSlidesAndLeavesForSomeSamplesTouchesOneSurfaceAtOnePlace) {
  ContactEstimator estimate({});
  press(estimate, {}, 4e-3, 0.2);
  const Vec3 place = estimate.contact().point;
  for (int n = 0; n < 1000; ++n) {
    const bool away = n % 50 >= 35;  // 15 ms in the air, 0.2 mm above the surface
    const Vec3 tip(0.03 * n * kPeriod, 0, away ? 0.2e-3 : -4e-3);
    const Vec3 force = away ? Vec3::Zero() : Vec3(-2.4, 0, 8);
    estimate.step({tip, Vec3(0.03, 0, 0), force, kPeriod});
    ASSERT_TRUE(estimate.contact().touching) << n;
    ASSERT_EQ(estimate.contact().surface, 1u) << n;
    ASSERT_NEAR(estimate.contact().point.z(), place.z(), 1e-6) << n;
    ASSERT_NEAR(estimate.contact().stiffness, 2000.0, 2.0) << n;
  }
}

TEST(ContactEstimator, FrictionThatLeansTheFirstForceLeavesTheStiffness) {
  ContactEstimator estimate({});
  const Wall wall{.stiffness = 5000.0};
  // The touch pushes an arm sideways. Friction tilts the force by atan(0.3) at first.
  Vec3 before(0, 0, 1e-4);
  for (int n = 0; n < 800; ++n) {
    const double t = n * kPeriod;
    const double swing = std::exp(-t / 0.1) * std::cos(2.0 * std::numbers::pi * 3.0 * t);
    const Vec3 tip(0.4e-3 * swing, 0, -0.8e-3 * (1.0 - std::exp(-t / 0.1)));
    const Vec3 velocity = (tip - before) / kPeriod;
    Vec3 force = wall.force(tip, velocity);
    if (std::abs(velocity.x()) > 1e-5) force.x() = std::copysign(0.3 * force.z(), -velocity.x());
    estimate.step({tip, velocity, force, kPeriod});
    before = tip;
  }
  EXPECT_NEAR(estimate.contact().stiffness, wall.stiffness, 0.1 * wall.stiffness);
}

TEST(ContactEstimator, ATouchThatIsSlowIsLearntWhenItHasShownEnough) {
  ContactEstimator estimate({});
  const Wall wall;
  for (int n = 1; n <= 2000; ++n) {
    const Vec3 tip(0, 0, -0.2e-3 - 0.3e-3 * n * kPeriod), velocity(0, 0, -0.3e-3);
    estimate.step({tip, velocity, wall.force(tip, velocity), kPeriod});
    if (n == 500) {
      EXPECT_EQ(estimate.contact().stiffness, 1000.0);
    }
  }
  EXPECT_NEAR(estimate.contact().stiffness, wall.stiffness, 1.0);
}

TEST(ContactEstimator, AWeightThatIsCarriedIsNoFriction) {
  ContactEstimator estimate({});
  // A gripper closes with some lateral force. It then lifts a load.
  for (int n = 0; n < 200; ++n)
    estimate.step({Vec3::Zero(), Vec3::Zero(), Vec3(0.3, 0, 0), kPeriod});
  for (int n = 0; n < 1500; ++n)
    estimate.step({Vec3(0, 0, 0.05 * n * kPeriod), Vec3(0, 0, 0.05), Vec3(0.25, 0, -1.5), kPeriod});
  EXPECT_LT(estimate.contact().normal.z(), -0.98);
  EXPECT_LT(estimate.contact().friction, 1.0);
}

TEST(ContactEstimator, WhatIsNotFiniteIsLeftOut) {
  ContactEstimator estimate({});
  const RemoteContact before = press(estimate, {}, 4e-3, 0.2);
  estimate.step({Vec3(kNan, 0, 0), Vec3::Zero(), Vec3(0, 0, 1), kPeriod});
  estimate.step({Vec3::Zero(), Vec3::Zero(), Vec3(0, kNan, 1), kPeriod});
  estimate.step({Vec3::Zero(), Vec3::Zero(), Vec3(0, 0, 1), 0.0});
  EXPECT_EQ(estimate.contact().point, before.point);
}

RemoteContact surface_at(double place) {
  return {.surface = 1, .touching = true, .point = Vec3(0, 0, place), .normal = Vec3::UnitZ()};
}

TEST(SurfaceOffset, TheFirstTouchMeetsTheHandWhereItIs) {
  SurfaceOffset index;
  const Vec3 hand(0.01, 0.0, -0.017);
  index.step(hand, Vec3::Zero(), surface_at(0.0), kPeriod);
  EXPECT_EQ(index.known_surface(), 1u);
  EXPECT_NEAR((hand - index.offset()).z(), 0.0, 1e-15);  // The target is on the surface.
  EXPECT_EQ(index.offset().x(), 0.0);
  // The estimate settles. The surface must stay at the hand.
  index.step(hand, Vec3::Zero(), surface_at(-0.002), kPeriod);
  EXPECT_NEAR((hand - index.offset()).z(), -0.002, 1e-15);
  // Later the hand must feel a change of the position.
  for (int n = 0; n < 150; ++n) index.step(hand, Vec3::Zero(), surface_at(-0.002), kPeriod);
  const Vec3 settled = index.offset();
  index.step(hand, Vec3::Zero(), surface_at(-0.001), kPeriod);
  EXPECT_EQ(index.offset(), settled);
}

TEST(SurfaceOffset, WhatAnotherLeaderMeetsMovesNoOffset) {
  SurfaceOffset index;
  const Vec3 hand(0.0, 0.0, -0.017);
  const SurfaceOffsetRole other{.meets = false};
  index.step(hand, Vec3::Zero(), surface_at(0.0), kPeriod, other);
  EXPECT_EQ(index.known_surface(), 1u);
  index.step(hand, Vec3::Zero(), surface_at(-0.01), kPeriod, other);
  EXPECT_TRUE(index.offset().isZero(0.0));
  // The offset must also stay when this leader becomes the leader in contact, because the surface
  // is already known.
  index.step(hand, Vec3::Zero(), surface_at(-0.012), kPeriod);
  EXPECT_TRUE(index.offset().isZero(0.0));
}

TEST(SurfaceOffset, AHandInTheAirKeepsItsIndexAndFreeMotionGivesBack) {
  SurfaceOffset index;
  index.step(Vec3(0, 0, 0.01), Vec3::Zero(), surface_at(0.0), kPeriod);
  EXPECT_TRUE(index.offset().isZero(0.0));
  SurfaceOffset deep;
  deep.step(Vec3(0, 0, -0.01), Vec3::Zero(), surface_at(0.0), kPeriod);
  for (int n = 0; n < 200; ++n)
    deep.step(Vec3(0, 0, -0.01), Vec3::Zero(), surface_at(0.0), kPeriod);
  RemoteContact left = surface_at(0.0);
  left.touching = false;
  deep.step(Vec3(0, 0, 0.02), Vec3(0, 0, 0.01), left, kPeriod);
  EXPECT_NEAR(deep.offset().z(), -0.01 + SurfaceOffset::kGivenBack * 0.01, 1e-15);
  for (int n = 0; n < 20; ++n) deep.step(Vec3(0, 0, 0.02), Vec3(0, 0, 0.01), left, kPeriod);
  EXPECT_NEAR(deep.offset().norm(), 0.0, 1e-15);
}

TEST(TargetLimiter, SaysWhichLimitIsWrong) {
  EXPECT_THROW(TargetLimiter({.stiffness = 0.0}), std::invalid_argument);
  EXPECT_THROW(TargetLimiter({.speed = kNan}), std::invalid_argument);
  EXPECT_THROW(TargetLimiter({.leash = -1.0}), std::invalid_argument);
}

TEST(TargetLimiter, HoldsWhatTheHandDoesNotKnowAndWhatItDidNotPay) {
  const TargetLimits limits;
  const Vec3 robot(0, 0, 0), wanted(0, 0, -0.05);
  const auto settle = [&](TargetLimiter& limiter, TargetLimiter::Sample s) {
    Vec3 target;
    for (int n = 0; n < 1000; ++n) target = limiter.step(s);
    return limits.stiffness * (target - s.robot).norm();
  };
  TargetLimiter unknown(limits), unpaid(limits), paid(limits), free(limits);
  EXPECT_NEAR(
      settle(unknown,
             {.wanted = wanted, .robot = robot, .surface = 1, .known = 0, .hand_work = 0.0}),
      limits.first_touch, 1e-9);
  EXPECT_NEAR(settle(unpaid, {.wanted = wanted, .robot = robot, .surface = 1, .known = 1}),
              limits.unfelt, 1e-9);
  paid.step({.wanted = robot, .robot = robot, .surface = 1, .known = 1});
  EXPECT_NEAR(
      settle(paid, {.wanted = wanted, .robot = robot, .surface = 1, .known = 1, .hand_work = 0.05}),
      limits.unfelt + std::sqrt(2.0 * limits.stiffness * 0.05), 1e-6);
  EXPECT_NEAR(settle(free, {.wanted = wanted, .robot = robot}), limits.leash, 1e-9);
}

/// A robot of 2 kg with the controller's spring, in front of a wall with friction and damping.
struct PushedRobot {
  static constexpr double kMass = 2.0, kSpring = 1000.0, kDamper = 60.0;
  Vec3 at = Vec3(0, 0, 1e-3), velocity = Vec3::Zero(), force = Vec3::Zero();
  void step(const Vec3& target, const Wall& wall) {
    force = wall.force(at, velocity);
    if (velocity.head<2>().norm() > 1e-6)
      force -= 0.3 * force.z() * Vec3(velocity.x(), velocity.y(), 0).normalized();
    velocity += kPeriod / kMass * (kSpring * (target - at) - kDamper * velocity + force);
    at += kPeriod * velocity;
  }
};

/// The guarantee of docs/teleoperation.md holds for all targets of the leader. The environment gets
/// at most the energy from the hand, plus `unfelt` per metre, plus the energy of the robot's spring
/// and mass.
TEST(TargetLimiter, TheEnvironmentGetsNoMoreThanTheHandPaid) {
  const TargetLimits limits{.speed = 2.0};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    TargetLimiter limiter(limits);
    PushedRobot robot;
    Vec3 wanted(0, 0, -0.05);
    const Wall wall{.damping = 2.0};
    double hand = 0.0, environment = 0.0, way = 0.0, fastest = 0.0, largest = 0.0, spring = 0.0;
    for (int n = 0; n < 4000; ++n) {
      if (n % 100 == 0)
        wanted = Vec3(0.05 * any(random), 0.05 * any(random), -0.05 + 0.04 * any(random));
      // The hand provides energy in bursts. In some runs the hand provides none.
      if (seed % 4 != 0 && n % 500 < 100) hand += 2e-4 * (1.0 + any(random));
      const bool touches = robot.force.z() > 0.0;
      const Vec3 target = limiter.step({.wanted = wanted,
                                        .robot = robot.at,
                                        .force = robot.force,
                                        .surface = touches ? 1u : 0u,
                                        .known = 1,
                                        .hand_work = hand});
      const Vec3 from = robot.at;
      robot.step(target, wall);
      const Vec3 moved = robot.at - from;
      fastest = std::max(fastest, robot.velocity.norm());
      if (!touches) {
        environment = way = 0.0;
        const double above =
            std::max(0.0, PushedRobot::kSpring * (target - robot.at).norm() - limits.unfelt);
        spring = 0.5 * above * above / PushedRobot::kSpring;
        continue;
      }
      environment -= robot.force.dot(moved);
      way += moved.norm();
      largest = std::max(largest, robot.force.norm());
      const double brought = 0.5 * PushedRobot::kMass * fastest * fastest;
      ASSERT_LE(environment, hand + limits.unfelt * way + spring + brought + 1e-9)
          << seed << ' ' << n;
    }
    if (seed % 4 != 0) {
      EXPECT_GT(largest, 2.0 * limits.unfelt) << "what was paid for is there";
    }
  }
}

TEST(TargetLimiter, TheFirstStepIsZeroAndNoStepIsFasterThanTheLimit) {
  const TargetLimits limits;
  TargetLimiter limiter(limits);
  const Vec3 robot(0.3, -0.2, 0.1);
  Vec3 before = limiter.step({.wanted = robot, .robot = robot});
  EXPECT_EQ(before, robot);
  for (const Vec3& wanted : {Vec3(9, 0, 0), Vec3(kNan, 0, 0), Vec3(-1e9, 1e9, 0), Vec3(robot)})
    for (int n = 0; n < 10; ++n) {
      const Vec3 target = limiter.step({.wanted = wanted, .robot = robot, .hand_work = kNan});
      ASSERT_TRUE(target.allFinite());
      EXPECT_LE((target - before).norm(), limits.speed * kPeriod * (1.0 + 1e-9));
      before = target;
    }
}

}  // namespace
}  // namespace feltwire::contact_estimator_test
