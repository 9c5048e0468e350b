// Compares a simulated rotating device with closed forms, and checks its energy.

#include <gmock/gmock.h>

#include <cmath>

#include "client/hands/simulated_device.hpp"

namespace feltwire::turning_device_test {
namespace {

using std::chrono::milliseconds;

constexpr double kInertia = 2e-4;  // [kg m^2] inertia of device and hand

/// Returns a handle without damping, friction, encoder quantization and wrist.
SimulatedHandOptions free_handle() {
  SimulatedHandOptions o;
  o.spec = builtin_device("simulated_6dof");
  o.spec.rotational_damping = 0.0;
  o.spec.rotation.friction = 0.0;
  o.spec.rotation.resolution = 0.0;
  o.spec.rotation.inertia = kInertia;
  o.spec.rotation.least_inertia = kInertia;
  o.hand = {.inertia = 0.0, .rotational_damping = 0.0, .rotational_stiffness = 0.0};
  return o;
}

void step(SimulatedDevice& device, int ms, const Vec3& torque) {
  device.read(milliseconds(ms));
  device.write({.torque = torque});
}

TEST(TurningDevice, AFreeHandleKeepsItsAngularMomentumAndTurnsEvenly) {
  SimulatedDevice device(free_handle());
  const Vec3 torque(0.01, -0.02, 0.015);
  step(device, 0, torque);
  step(device, 100, Vec3::Zero());
  // angular velocity = torque times time over inertia
  const Vec3 velocity = 0.1 / kInertia * torque;
  EXPECT_NEAR((device.true_angular_velocity() - velocity).norm(), 0.0, 1e-9 * velocity.norm());
  const Quaternion begin = device.true_orientation();
  for (int ms = 101; ms <= 1100; ++ms) {
    step(device, ms, Vec3::Zero());
    ASSERT_NEAR((device.true_angular_velocity() - velocity).norm(), 0.0, 1e-9 * velocity.norm());
    const Quaternion closed = turned(begin, 1e-3 * (ms - 100) * velocity);
    ASSERT_NEAR(rotation_between(closed, device.true_orientation()).norm(), 0.0, 1e-7) << ms;
  }
  EXPECT_NEAR(device.true_orientation().norm(), 1.0, 1e-12);
}

TEST(TurningDevice, AWristThatIsPushedSwingsAsTheClosedFormOfSpringAndDamper) {
  SimulatedHandOptions o = free_handle();
  o.spec.rotational_damping = 1e-3;
  o.hand.rotational_stiffness = 0.5;
  o.hand.rotational_damping = 4e-3;
  SimulatedDevice device(o);
  const Vec3 axis = Vec3(1.0, 2.0, -2.0) / 3.0;
  const double torque = 0.05, k = 0.5, b = 5e-3;
  const double decay = b / (2.0 * kInertia), natural = std::sqrt(k / kInertia);
  const double swing = std::sqrt(natural * natural - decay * decay);
  step(device, 0, torque * axis);
  for (int ms = 1; ms <= 400; ++ms) {
    step(device, ms, torque * axis);
    const double t = 1e-3 * ms;
    const double angle =
        torque / k *
        (1.0 - std::exp(-decay * t) * (std::cos(swing * t) + decay / swing * std::sin(swing * t)));
    const Vec3 turn = rotation_between(Quaternion::Identity(), device.true_orientation());
    ASSERT_NEAR((turn - angle * axis).norm(), 0.0, 1e-4) << ms << " ms, of " << torque / k;
  }
}

/// The work of the torque must equal the kinetic energy plus the loss by damping and friction.
TEST(TurningDevice, TheEnergyOfTheHeldTorqueIsKineticOrBurned) {
  SimulatedHandOptions o = free_handle();
  const double b = 2e-3, friction = 3e-3;
  o.spec.rotational_damping = b;
  o.spec.rotation.friction = friction;
  SimulatedDevice device(o);
  double given = 0.0, burned = 0.0, largest = 0.0;
  Quaternion before = device.true_orientation();
  Vec3 held = Vec3::Zero();
  constexpr int kFine = 50;  // [us] step that brings the sum close to the integral
  for (int n = 0; n <= 40000; ++n) {
    const double t = 1e-6 * kFine * n;
    device.read(std::chrono::microseconds(kFine * n));
    const Vec3 turn = rotation_between(before, device.true_orientation());
    given += held.dot(turn);
    burned += b * turn.squaredNorm() / (1e-6 * kFine) + friction * turn.lpNorm<1>();
    before = device.true_orientation();
    held = {0.03 * std::sin(9.0 * t), 0.02 * std::cos(14.0 * t), -0.02 * std::sin(5.0 * t)};
    device.write({.torque = held});
    const double kinetic = 0.5 * kInertia * device.true_angular_velocity().squaredNorm();
    largest = std::max(largest, std::abs(given - burned - kinetic));
  }
  EXPECT_GT(burned, 0.02) << "[J]";
  EXPECT_LT(largest, 0.01 * burned);
}

/// At each change of torque, the encoder angle is wrong by half a quantum at most. The energy error
/// is therefore limited.
TEST(TurningDevice, EnergyAtTheEncoderIsThatOfTheTrueTurnsToHalfAQuantumAChange) {
  SimulatedHandOptions o = free_handle();
  o.spec.rotation.resolution = 5.75e-4;
  o.hand = with_wrist(Hand{});
  SimulatedDevice device(o);
  double true_energy = 0.0, measured_energy = 0.0, changes = 0.0;
  Quaternion true_before = device.true_orientation(), measured_before = true_before;
  Vec3 held = Vec3::Zero();
  for (int ms = 0; ms <= 3000; ++ms) {
    const Quaternion measured = device.read(milliseconds(ms)).pose.orientation;
    const Vec3 true_turn = rotation_between(true_before, device.true_orientation());
    const Vec3 turn = rotation_between(measured_before, measured);
    true_energy += held.dot(true_turn);
    measured_energy += held.dot(turn);
    true_before = device.true_orientation();
    measured_before = measured;
    const Vec3 next(0.1 * std::sin(0.004 * ms), 0.0, 0.05 * std::sin(0.007 * ms));
    changes += (next - held).lpNorm<1>();
    held = device.write({.torque = next}).torque;
    ASSERT_LE(std::abs(true_energy - measured_energy),
              1.02 * 0.5 * o.spec.rotation.resolution * (changes + held.lpNorm<1>()) + 1e-12)
        << ms;
  }
  EXPECT_NE(true_energy, measured_energy) << "the quantum is felt";
}

TEST(TurningDevice, ReadsTurnsOfWholeQuantaWithinHalfAQuantumOfTheTruth) {
  SimulatedHandOptions o = free_handle();
  const double quantum = 5.75e-4;
  o.spec.rotation.resolution = quantum;
  SimulatedDevice device(o);
  Quaternion before = device.read(milliseconds(0)).pose.orientation;
  device.write({.torque = {0.01, 0.02, -0.005}});
  double farthest = 0.0;
  for (int ms = 1; ms <= 200; ++ms) {
    const Quaternion measured = device.read(milliseconds(ms)).pose.orientation;
    const Vec3 error = rotation_between(measured, device.true_orientation());
    ASSERT_LE(error.lpNorm<Eigen::Infinity>(), 0.5 * quantum * (1.0 + 1e-9)) << ms;
    const double turn = rotation_between(before, measured).norm();
    ASSERT_TRUE(turn == 0.0 || turn > 0.9 * quantum) << ms;
    farthest = std::max(farthest, turn);
    before = measured;
  }
  EXPECT_GT(farthest, 10.0 * quantum) << "readings may be many quanta apart";
}

TEST(TurningDevice, DryFrictionHoldsAndNeverTurnsItRound) {
  SimulatedHandOptions o = free_handle();
  o.spec.rotation.friction = 4e-3;
  SimulatedDevice device(o);
  step(device, 0, {3.9e-3, 0.0, 0.0});
  step(device, 500, {8e-3, 0.0, 0.0});
  EXPECT_EQ(device.true_angular_velocity(), Vec3::Zero()) << "below the friction nothing turns";
  step(device, 600, Vec3::Zero());
  EXPECT_NEAR(device.true_angular_velocity().x(), 4e-3 / kInertia * 0.1, 1e-9);
  step(device, 2000, Vec3::Zero());
  EXPECT_EQ(device.true_angular_velocity(), Vec3::Zero());
}

TEST(TurningDevice, HoldsNoMoreTorqueThanItsMotorsCanAndNoneWhenReleased) {
  SimulatedDevice device(free_handle());
  const Command held = device.write({.elastic = {1.0, 0.0, 0.0}, .torque = {0.6, 0.8, 0.0}});
  EXPECT_NEAR(held.torque.norm(), 0.356, 1e-12);
  EXPECT_NEAR(held.torque.y() / held.torque.x(), 4.0 / 3.0, 1e-12) << "its direction is kept";
  EXPECT_EQ(held.force(), Vec3(1.0, 0.0, 0.0)) << "force has a limit of its own";
  const Command nonsense = device.write({.torque = {std::nan(""), 0.0, 0.0}});
  EXPECT_EQ(nonsense, Command{});
  device.write({.torque = {0.1, 0.0, 0.0}});
  device.read(milliseconds(0));
  device.release();
  device.read(milliseconds(100));
  EXPECT_EQ(device.true_angular_velocity(), Vec3::Zero());
  EXPECT_EQ(device.write({.torque = {0.1, 0.0, 0.0}}), Command{});
}

TEST(TurningDevice, FollowsAnIntendedTurnWithItsWrist) {
  SimulatedHandOptions o;
  o.spec = builtin_device("sigma.7");
  o.wrist = {.path = WristPath::screwdriver, .angle = 0.8};
  SimulatedDevice device(o);
  double most = 0.0;
  for (int ms = 0; ms <= 2000; ++ms) {
    device.read(milliseconds(ms));
    const Vec3 turn = rotation_between(Quaternion::Identity(), device.true_orientation());
    ASSERT_NEAR(turn.head<2>().norm(), 0.0, 1e-9) << "about the normal alone";
    most = std::max(most, turn.z());
  }
  EXPECT_NEAR(most, 0.8, 0.08);
}

TEST(TurningDevice, ADeviceThatSensesNoRotationStaysAsItIs) {
  SimulatedHandOptions o;
  o.spec = builtin_device("simulated");
  o.wrist = {.path = WristPath::roll, .angle = 1.0};
  SimulatedDevice device(o);
  device.read(milliseconds(0));
  EXPECT_EQ(device.read(milliseconds(700)).pose.orientation.coeffs(),
            Quaternion::Identity().coeffs());
}

TEST(TurningDevice, OneThatNobodyTurnsReadsTheIdentityExactly) {
  SimulatedHandOptions o;
  o.spec = builtin_device("omega.7");
  o.task.path = HandPath::slide;
  SimulatedDevice device(o);
  for (int ms = 0; ms <= 500; ++ms)
    ASSERT_EQ(device.read(milliseconds(ms)).pose.orientation.coeffs(),
              Quaternion::Identity().coeffs());
}

TEST(TurningDevice, AWristOfTheArmTurnsAsTheHandMoves) {
  const Hand hand = with_wrist({.mass = 0.2, .damping = 10.0, .stiffness = 1000.0});
  EXPECT_NEAR(hand.inertia, 3.2e-4, 1e-12);
  EXPECT_NEAR(hand.rotational_stiffness / hand.inertia, hand.stiffness / hand.mass, 1e-9);
  EXPECT_NEAR(hand.rotational_damping / hand.inertia, hand.damping / hand.mass, 1e-9);
}

}  // namespace
}  // namespace feltwire::turning_device_test
