// Tests the simulated arm in free space: its springs, its limits, its energy.

#include "client/simulated_robots/arm.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "core/base/splitmix.hpp"
#include "tests/client/simulated_robots/arm_support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::arm_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Arm, SaysWhatItIs) {
  const Arm arm(config_of("arm"));
  const FollowerSpec& spec = arm.spec();
  EXPECT_EQ(spec.stiffness, 1000.0);
  EXPECT_NEAR(spec.damping, 2.0 * std::sqrt(1000.0 * spec.mass), 1e-9);
  EXPECT_GT(spec.mass, 1.0);
  EXPECT_LT(spec.mass, 17.8);
  // A sampled spring is passive if b_f >= K T / 2. The step T of the controller is half a servo
  // period. This check uses a complete servo period, which is stricter.
  EXPECT_GE(spec.own_damping, 0.5 * spec.stiffness * spec.servo_period);
  EXPECT_NEAR(spec.wrench_noise, 0.08, 1e-12);
  EXPECT_NEAR(spec.gripper_opening, 0.08, 1e-12);
}

TEST(Arm, StandsStillWithoutAForce) {
  Robot run("arm");
  const Vec3 before = run.reading.pose.position;
  run.wait(1.0);
  EXPECT_LT((run.reading.pose.position - before).norm(), 1e-6);
  EXPECT_LT(run.mean_force(0.5).norm(), 0.01);
}

TEST(Arm, GoesToItsTarget) {
  Robot run("arm");
  const Vec3 to = run.target.pose.position + Vec3(0.1, 0.1, -0.1);
  run.target.pose.orientation =
      Quaternion(Eigen::AngleAxisd(0.15, Vec3::UnitX())) * run.target.pose.orientation;
  run.move(to, 2.0);
  run.wait(1.0);
  // No error may remain. The estimated null space is inexact, but neither the posture control nor
  // the limits may cause an error.
  EXPECT_LT((run.reading.pose.position - to).norm(), 2e-5);
  EXPECT_LT(rotation_between(run.reading.pose.orientation, run.target.pose.orientation).norm(),
            1e-3);
}

TEST(Arm, FollowsAnEvenMotionWithoutADampersLag) {
  Robot run("arm");
  constexpr double kSpeed = 0.1;  // [m/s]
  run.move(run.target.pose.position + Vec3(kSpeed, 0.0, 0.0), 1.0);
  const double lag = run.target.pose.position.x() - run.reading.pose.position.x();
  // Only the friction of the joints remains. A damper to the ground would add B v / K: 10 mm.
  EXPECT_LT(std::abs(lag), 5e-3);
  EXPECT_GT(run.arm.spec().damping * kSpeed / run.arm.spec().stiffness, 8e-3);
}

TEST(Arm, YieldsToAForceByItsStiffness) {
  Robot run("arm");
  const Vec3 before = run.reading.pose.position;
  for (const Vec3& force : {Vec3(5.0, 0.0, 0.0), Vec3(0.0, -5.0, 0.0), Vec3(0.0, 0.0, 5.0)}) {
    run.arm.push(force);
    run.wait(2.0);
    const Vec3 moved = run.reading.pose.position - before;
    EXPECT_LT((moved - force / run.arm.spec().stiffness).norm(), 0.02 * moved.norm());
    // The sensor must also measure this force.
    EXPECT_LT((run.mean_force(0.5) - force).norm(), 0.01);
  }
}

TEST(Arm, SensorAgreesToItsNoise) {
  Robot run("arm");
  const double most = run.arm.spec().wrench_noise;
  double squares = 0.0, largest = 0.0;
  int count = 0;
  for (int i = 0; i < 4000; ++i) {
    // The arm oscillates freely with the tool's inertia, up to 3 m/s^2.
    run.target.pose.position.y() = 0.05 * std::sin(2.0 * M_PI * run.time());
    const Vec3 wrong = *run.tick().force - run.arm.contact_force();
    largest = std::max(largest, wrong.norm());
    squares += wrong.squaredNorm();
    ++count;
  }
  // The controller does not compensate the tool's rotational inertia. The effect is some
  // thousandths.
  EXPECT_NEAR(std::sqrt(squares / (3.0 * count)), 0.02, 0.004);
  EXPECT_LT(largest, most + 0.05);
}

TEST(Arm, SameSeedSameBits) {
  const auto run = [](std::uint64_t seed) {
    ArmConfig config = config_of("table");
    config.seed = seed;
    Robot r(config);
    r.move(Vec3(0.45, 0.05, 0.295), 0.8);
    std::vector<double> all;
    for (int i = 0; i < 200; ++i) {
      const FollowerReading& reading = r.tick();
      for (int k = 0; k < 3; ++k) {
        all.push_back(reading.pose.position[k]);
        all.push_back((*reading.force)[k]);
      }
    }
    return all;
  };
  const auto bits = [](const std::vector<double>& v) {
    std::vector<std::uint64_t> words;
    for (const double x : v) words.push_back(std::bit_cast<std::uint64_t>(x));
    return words;
  };
  EXPECT_EQ(bits(run(3)), bits(run(3)));
  EXPECT_NE(bits(run(3)), bits(run(4)));
}

TEST(Arm, AllocatesNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers bring their own allocator";
#endif
  Robot run("table");
  run.move(Vec3(0.45, 0.0, 0.32), 0.5);
  const std::size_t before = test::allocations();
  run.move(Vec3(0.45, 0.0, 0.29), 0.5);
  run.target.gripper = 0.0;
  run.wait(0.2);
  EXPECT_EQ(test::allocations() - before, 0u);
}

TEST(Arm, RefusesTargetsThatAreNotFinite) {
  Robot run("arm");
  run.wait(0.1);
  const FollowerTarget good = run.held;
  const auto refuses = [&](const FollowerTarget& bad) {
    run.target = bad;
    run.tick();
    return run.held.pose.position == good.pose.position && run.held.gripper == good.gripper &&
           run.held.pose.orientation.coeffs() == good.pose.orientation.coeffs() && run.reading.ok;
  };
  FollowerTarget bad = good;
  bad.pose.position.y() = kNan;
  EXPECT_TRUE(refuses(bad));
  bad = good;
  bad.pose.orientation.w() = kNan;
  EXPECT_TRUE(refuses(bad));
  bad.pose.orientation = Quaternion(0.0, 0.0, 0.0, 0.0);
  EXPECT_TRUE(refuses(bad));
  bad = good;
  bad.gripper = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(refuses(bad));
  run.target = good;
  run.wait(0.2);
  EXPECT_LT((run.reading.pose.position - good.pose.position).norm(), 1e-5);
}

TEST(Arm, SaysWhatItReallyHolds) {
  Robot run("arm");
  const Vec3 from = run.reading.pose.position;
  run.target.pose.position = from + Vec3(0.5, 0.0, 0.0);
  run.target.gripper = 1.0;
  run.tick();
  // 30 N at 1 kN/m.
  EXPECT_NEAR((run.held.pose.position - from).norm(), 0.03, 1e-9);
  EXPECT_NEAR(run.held.gripper, 0.08, 1e-12);
  EXPECT_EQ(run.reading.commanded.position, run.held.pose.position);
  double fastest = 0.0;
  for (int i = 0; i < 300; ++i) fastest = std::max(fastest, run.tick().velocity.norm());
  // The arm moves slowly, because its fully stretched spring acts against its damper.
  EXPECT_LT(fastest, 30.0 / run.arm.spec().damping * 1.05);
}

TEST(Arm, RespectsItsJointsLimitsAndTorques) {
  Robot run("arm");
  constexpr double kSlack = 0.01;  // [rad] MuJoCo's own limits are soft.
  double nearest = 1.0;
  std::uint64_t draw = 0;
  for (int aim = 0; aim < 20; ++aim) {
    const auto unit = [&] {
      return 2.0 * static_cast<double>(splitmix::draw(5, draw++) >> 11) / 9007199254740992.0 - 1.0;
    };
    run.target.pose.position = Vec3(0.9 * unit(), 0.9 * unit(), 0.5 + 0.8 * unit());
    run.target.pose.orientation =
        Quaternion(Eigen::AngleAxisd(M_PI * unit(), Vec3(unit(), unit(), unit()).normalized()));
    for (int i = 0; i < 1000; ++i) {
      run.tick();
      for (int a = 0; a < 7; ++a) {
        const Arm::Limits limits = run.arm.limits(a);
        const double room = std::min(run.arm.angle(a) - limits.low, limits.high - run.arm.angle(a));
        nearest = std::min(nearest, room);
        ASSERT_GT(room, -kSlack) << "axis " << a + 1;
        ASSERT_LE(std::abs(run.arm.torque(a)), limits.torque);
      }
      ASSERT_TRUE(run.reading.ok);
    }
  }
  EXPECT_LT(nearest, 0.08) << "no limit was tried";
}

/// Property 6.2 of the theory: while the target rests, no external force may extract more energy
/// from the arm than its springs and masses store.
TEST(Arm, IsPassiveWhileItsTargetStands) {
  Robot run("arm");
  run.move(run.target.pose.position + Vec3(0.1, 0.05, -0.05), 1.0);
  run.wait(0.5);
  const double held = run.arm.energy();
  double taken = 0.0, most = -1.0, work = 0.0;
  Vec3 before = run.reading.pose.position, force = Vec3::Zero();
  std::uint64_t draw = 0;
  const auto unit = [&] {
    return 2.0 * static_cast<double>(splitmix::draw(9, draw++) >> 11) / 9007199254740992.0 - 1.0;
  };
  for (int i = 0; i < 20000; ++i) {
    // The force pushes in one direction for some time. The force then brakes the movement, which
    // extracts the most energy.
    if (i % 50 == 0) force = 25.0 * Vec3(unit(), unit(), unit());
    const bool brakes = (i / 200) % 2 == 1;
    const Vec3 v = run.reading.velocity;
    const Vec3 now = brakes && v.norm() > 1e-6 ? Vec3(-25.0 * v.normalized()) : force;
    run.arm.push(now);
    run.tick();
    const double done = -now.dot(run.reading.pose.position - before);
    before = run.reading.pose.position;
    taken += done;
    work += std::abs(done);
    most = std::max(most, taken);
    ASSERT_FALSE(run.reading.stopped);
  }
  EXPECT_GT(work, 20.0);  // [J] The external force must do work.
  EXPECT_LE(most, held);
  EXPECT_LT(taken, -0.3 * work);  // The arm itself dissipates energy.
}

TEST(Arm, HoldsWhereItIsAfterHold) {
  Robot run("arm");
  run.target.pose.position.x() += 0.2;
  run.wait(0.3);
  std::thread([&] { run.arm.hold(); }).join();
  run.tick();
  const Vec3 at = run.reading.pose.position;
  run.target.pose.position.z() -= 0.1;
  run.wait(1.0);
  // The arm may move only as far as its momentum carries it.
  EXPECT_LT((run.reading.pose.position - at).norm(), 5e-3);
  EXPECT_LT(run.reading.velocity.norm(), 1e-3);
  EXPECT_LT((run.held.pose.position - at).norm(), 1e-3);
  EXPECT_TRUE(run.reading.ok);
}

TEST(Arm, StopsAboveItsWrenchLimit) {
  ArmConfig config = config_of("arm");
  config.stop_force = 20.0;
  Robot run(config);
  run.arm.push({0.0, 0.0, -22.0});
  run.wait(0.05);
  EXPECT_TRUE(run.reading.stopped);
  run.arm.push(Vec3::Zero());
  run.wait(1.0);
  const Vec3 at = run.reading.pose.position;
  run.target.pose.position.x() += 0.02;
  run.wait(0.5);
  EXPECT_TRUE(run.reading.stopped);
  EXPECT_LT((run.reading.pose.position - at).norm(), 1e-4);
  run.arm.resume();
  run.wait(1.0);
  EXPECT_FALSE(run.reading.stopped);
  EXPECT_LT((run.reading.pose.position - run.target.pose.position).norm(), 1e-4);
}

TEST(Arm, GripperFollowsItsTarget) {
  Robot run("arm");
  run.target.gripper = 0.03;
  run.wait(1.0);
  EXPECT_NEAR(run.reading.gripper, 0.03, 1e-5);
  EXPECT_LT(run.reading.gripper_force, 0.1);
  EXPECT_LT((run.reading.pose.position - run.target.pose.position).norm(), 1e-5);
}

}  // namespace
}  // namespace feltwire::arm_test
