// Compares the plant of a simulated device with closed forms, and checks its energy.

#include "client/hands/plant_motion.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "client/hands/simulated_device.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::plant_motion_test {
namespace {

constexpr double kTick = 1e-3;  // [s]

/// Returns a device of 0.08 kg without friction.
DeviceSpec smooth_spec() {
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = 0.0;
  spec.coulomb_friction = 0.0;
  spec.position_resolution = 0.0;
  spec.apparent_mass = 0.08;
  spec.max_force = spec.continuous_force = 50.0;
  return spec;
}

/// Runs the plant for `span` [s] with a constant intended position.
void run(PlantMotion& motion, double begin, double span, const Vec3& intended = Vec3::Zero()) {
  const int steps = static_cast<int>(std::ceil(span / motion.longest_step()));
  for (int i = 0; i < steps; ++i)
    motion.step(begin + i * span / steps, span / steps, intended, Vec3::Zero());
}

Plant with_transmission(double stiffness, double damping, double handle_mass) {
  Plant plant;
  plant.transmission = {.stiffness = stiffness, .damping = damping, .handle_mass = handle_mass};
  return plant;
}

TEST(PlantMotion, TheTransmissionSwingsAsTwoMassesOnASpringDo) {
  constexpr double kMotor = 0.06, kHandle = 0.02, kStiffness = 10e3, kForce = 2.0;
  PlantMotion motion(with_transmission(kStiffness, 0.0, kHandle), smooth_spec(), kNoHand);
  motion.write(0.0, Vec3(kForce, 0, 0));
  // The centre of mass of motor and handle moves by F t^2 / (2 (m + M)). The spring oscillates
  // about F M_h / (k (m + M)).
  const double whole = kMotor + kHandle, reduced = kMotor * kHandle / whole;
  const double w = std::sqrt(kStiffness / reduced);
  for (int n = 0; n < 100; ++n) {
    run(motion, n * kTick, kTick);
    const double t = (n + 1) * kTick;
    const double squeezed = kForce * kHandle / (kStiffness * whole) * (1.0 - std::cos(w * t));
    const double middle = 0.5 * kForce / whole * t * t;
    EXPECT_NEAR(motion.motor_position().x() - motion.handle_position().x(), squeezed,
                2e-3 * kForce / kStiffness)
        << t;
    EXPECT_NEAR(
        (kMotor * motion.motor_position().x() + kHandle * motion.handle_position().x()) / whole,
        middle, 1e-9)
        << t;
  }
}

TEST(PlantMotion, TheTransmissionsDamperEndsItsSwing) {
  constexpr double kMotor = 0.06, kHandle = 0.02, kStiffness = 10e3, kDamping = 4.0;
  PlantMotion motion(with_transmission(kStiffness, kDamping, kHandle), smooth_spec(), kNoHand);
  motion.write(0.0, Vec3(0, 1, 0));
  const double reduced = kMotor * kHandle / (kMotor + kHandle);
  const double decay = kDamping / (2.0 * reduced);
  const double w = std::sqrt(kStiffness / reduced - decay * decay);
  const double rest = kHandle / (kStiffness * (kMotor + kHandle));
  for (int n = 0; n < 30; ++n) {
    run(motion, n * kTick, kTick);
    const double t = (n + 1) * kTick;
    const double expected =
        rest * (1.0 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
    EXPECT_NEAR(motion.motor_position().y() - motion.handle_position().y(), expected, 2e-4 * rest)
        << t;
  }
}

TEST(PlantMotion, AForceRisesAsAFilterOfFirstOrderLetsIt) {
  Plant plant;
  plant.amplifier.lag = 0.3e-3;
  PlantMotion motion(plant, smooth_spec(), kNoHand);
  motion.write(0.0, Vec3(4, 0, 0));
  for (int n = 0; n < 40; ++n) {
    run(motion, n * 1e-4, 1e-4);
    const double t = (n + 1) * 1e-4, left = std::exp(-t / plant.amplifier.lag);
    EXPECT_NEAR(motion.motor_force().x(), 4.0 * (1.0 - left), 1e-12) << t;
    const double speed = 4.0 / 0.08 * (t - plant.amplifier.lag * (1.0 - left));
    EXPECT_NEAR(motion.motor_velocity().x(), speed, 1e-12) << t;
  }
}

TEST(PlantMotion, APureDelayHoldsTheForceBackAndKeepsIt) {
  Plant plant;
  plant.amplifier.delay = 0.35e-3;
  PlantMotion motion(plant, smooth_spec(), kNoHand);
  motion.write(0.0, Vec3(4, 0, 0));
  run(motion, 0.0, 0.34e-3);
  EXPECT_EQ(motion.motor_velocity().x(), 0.0);
  run(motion, 0.34e-3, kTick - 0.34e-3);
  // The delay is not rounded to a step: the force acted for 0.65 ms.
  EXPECT_NEAR(motion.motor_velocity().x(), 4.0 / 0.08 * 0.65e-3, 1e-14);
  motion.write(kTick, Vec3::Zero());
  run(motion, kTick, kTick);
  EXPECT_NEAR(motion.motor_velocity().x(), 4.0 / 0.08 * 1e-3, 1e-14);
  EXPECT_EQ(motion.motor_force(), Vec3::Zero());
}

TEST(PlantMotion, JitterStaysWithinItsBoundAndTheNewestForceStays) {
  Amplifier amplifier({.delay = 0.2e-3, .jitter = 2.5e-3}, 7);
  constexpr int kParts = 20;
  constexpr double kPart = kTick / kParts, kRounding = 1e-9;
  double soonest = 1.0;
  int late = 0;
  for (int n = 1; n < 4000; ++n) {
    const double time = n * kTick;
    amplifier.write(time, Vec3(n, 0, 0));
    double shown = 0.0;
    for (int i = 0; i < kParts; ++i) {
      EXPECT_LE(amplifier.mean(time + i * kPart, kPart).x(), n + kRounding);
      const double now = amplifier.output().x();
      EXPECT_GE(now, shown) << "an older force came after a newer one";
      shown = now;
      if (now == n) soonest = std::min(soonest, (i + 1) * kPart);
    }
    EXPECT_GE(shown, n - 3.0);  // No force is later than delay plus jitter.
    late += shown < n ? 1 : 0;
  }
  EXPECT_GE(soonest, 0.2e-3);
  // Each force arrives at its own time, possibly before an older one. In 0.8 / 2.5 of the cases the
  // force arrives within its own tick.
  EXPECT_NEAR(1.0 - late / 3999.0, 0.8 / 2.5, 0.03);
}

TEST(PlantMotion, AForceHasTheResolutionOfItsAmplifier) {
  Amplifier amplifier({.resolution = 0.008}, 1);
  amplifier.write(0.0, Vec3(0.0041, -1.0, 0.0039));
  amplifier.mean(0.0, kTick);
  EXPECT_NEAR((amplifier.output() - Vec3(0.008, -1.0, 0.0)).norm(), 0.0, 1e-12);
}

/// The distance [m] that 0.08 kg coasts from 0.05 m/s, and the least speed on the way.
struct Coast {
  double way, least_speed;
};
Coast coast(PlantMotion& motion) {
  motion.write(0.0, Vec3(4, 0, 0));
  run(motion, 0.0, kTick);
  motion.write(kTick, Vec3::Zero());
  const double from = motion.motor_position().x();
  double least = motion.motor_velocity().x();
  for (int n = 1; n < 500; ++n) {
    run(motion, n * kTick, kTick);
    least = std::min(least, motion.motor_velocity().x());
  }
  return {motion.motor_position().x() - from, least};
}

TEST(PlantMotion, DryFrictionStopsTheMotorAndNeverTurnsItRound) {
  DeviceSpec spec = smooth_spec();
  spec.coulomb_friction = 0.05;
  Plant rigid;
  PlantMotion motion(rigid, spec, kNoHand);
  const Coast seen = coast(motion);
  const double speed = (4.0 - 0.05) / 0.08 * kTick;
  EXPECT_NEAR(seen.way, 0.5 * 0.08 * speed * speed / 0.05, 1e-6 * seen.way + 1e-8);
  EXPECT_EQ(seen.least_speed, 0.0);
  const Vec3 rest = motion.motor_position();
  motion.write(0.5, Vec3(0.0499, 0, 0));
  run(motion, 0.5, 0.1);
  EXPECT_EQ(motion.motor_position(), rest);
  EXPECT_EQ(motion.motor_velocity(), Vec3::Zero());
}

TEST(PlantMotion, ItTakesTheBreakawayForceToMoveAndLessToGoOn) {
  DeviceSpec spec = smooth_spec();
  spec.coulomb_friction = 0.04;
  Plant plant;
  plant.friction = {.breakaway = 0.08, .stribeck_velocity = 2e-3};
  PlantMotion motion(plant, spec, kNoHand);
  motion.write(0.0, Vec3(0.0799, 0, 0));
  run(motion, 0.0, 0.1);
  EXPECT_EQ(motion.motor_position(), Vec3::Zero());
  motion.write(0.1, Vec3(0.0801, 0, 0));
  run(motion, 0.1, 0.3);
  EXPECT_GT(motion.motor_velocity().x(), 0.01);
  // Far above the Stribeck velocity, only the device's friction of 0.04 N opposes the force of
  // 0.0801 N.
  const double fast = motion.motor_velocity().x();
  run(motion, 0.4, 0.1);
  EXPECT_NEAR(motion.motor_velocity().x() - fast, (0.0801 - 0.04) / 0.08 * 0.1, 1e-9);
  EXPECT_EQ(coast(motion).least_speed, 0.0);
}

TEST(PlantMotion, TheMotorCrossesTheBacklashAndThenTakesTheHandleWithIt) {
  constexpr double kWidth = 100e-6;
  Plant plant = with_transmission(20e3, 5.0, 0.02);
  plant.transmission.backlash = kWidth;
  DeviceSpec spec = smooth_spec();
  PlantMotion motion(plant, spec, Hand{.mass = 0.0, .damping = 20.0, .stiffness = 1e4});
  // The motor presses softly to one side, then to the other. The hand's spring holds the handle
  // within 0.2 mm.
  std::vector<double> gaps;
  for (const double force : {2.0, -2.0}) {
    motion.write(gaps.empty() ? 0.0 : 1.0, Vec3(0, 0, force));
    run(motion, gaps.empty() ? 0.0 : 1.0, 1.0);
    gaps.push_back(motion.motor_position().z() - motion.handle_position().z());
    EXPECT_NEAR(motion.handle_position().z(), force / 1e4, 1e-9);
  }
  EXPECT_NEAR(gaps[0] - gaps[1], kWidth + 2.0 * 2.0 / 20e3, 1e-9);
  // In the middle of the gap no force reaches the handle.
  PlantMotion free(plant, spec, kNoHand);
  free.write(0.0, Vec3(0, 0, 1.0));
  const double until = std::sqrt(2.0 * (0.5 * kWidth) / (1.0 / 0.06));
  run(free, 0.0, 0.99 * until);
  EXPECT_EQ(free.handle_position(), Vec3::Zero());
  run(free, 0.99 * until, 2e-3);
  EXPECT_GT(free.handle_position().z(), 0.0);
}

/// Returns a plant with all effects.
Plant rich_plant() {
  Plant plant = with_transmission(8e3, 1.5, 0.02);
  plant.transmission.backlash = 30e-6;
  plant.amplifier = {.lag = 0.3e-3, .delay = 0.1e-3, .jitter = 0.1e-3, .resolution = 0.008};
  plant.friction = {.breakaway = 0.2, .stribeck_velocity = 2e-3};
  plant.encoder = {.noise = 1e-6};
  plant.hand.pad_stiffness = 1500.0;
  plant.hand.pad_damping = 2.0;
  plant.hand.reflex_delay = 0.04;
  plant.hand.reflex_stiffness = 60.0;
  plant.hand.reflex_damping = 0.5;
  plant.hand.grip = {{0.2, 1.0}, {0.4, 3.0}, {0.6, 0.5}};
  return plant;
}

/// Applies a force that changes every tick while the hand moves, from 0 to `until` [s]. Calls
/// `look` after every tick.
template <class Look>
void shake(PlantMotion& motion, double until, const Look& look) {
  const int steps = static_cast<int>(std::ceil(kTick / motion.longest_step()));
  const double h = kTick / steps;
  Vec3 intended = Vec3::Zero();
  for (int n = 0; n * kTick < until; ++n) {
    const double t = n * kTick;
    motion.write(t, Vec3(2 * std::sin(70 * t), 3 * std::cos(31 * t), (n / 50) % 2 ? 1.0 : -1.0));
    const Vec3 velocity(0.05 * std::cos(9 * t), -0.03 * std::sin(5 * t), 0.04 * std::cos(3 * t));
    for (int i = 0; i < steps; ++i)
      motion.step(t + i * h, h, intended + i * h * velocity, velocity);
    intended += kTick * velocity;
    look();
  }
}
void shake(PlantMotion& motion, double until) {
  shake(motion, until, [] {});
}

/// Returns the largest error of the energy balance, relative to the energy that flowed. The
/// integration must neither make nor lose energy.
double imbalance(PlantMotion& motion) {
  double worst = 0.0;
  shake(motion, 1.0, [&] {
    const PlantFlow& f = motion.flow();
    const double flowed = std::abs(f.given) + std::abs(f.by_arm) + f.burned + f.lost;
    worst = std::max(worst,
                     std::abs(f.given + f.by_arm - motion.stored() - f.burned - f.lost) / flowed);
  });
  return worst;
}

TEST(PlantMotion, WorkInIsWhatIsStoredAndWhatIsBurned) {
  DeviceSpec spec = smooth_spec();
  spec.damping = 0.4;
  spec.coulomb_friction = 0.1;
  const Hand hand{.mass = 0.05, .damping = 2.0, .stiffness = 200.0};
  PlantMotion rich(rich_plant(), spec, hand);
  EXPECT_LT(imbalance(rich), 1e-9);
  EXPECT_GT(rich.flow().burned, 1e-3);
  EXPECT_GT(rich.flow().lost, 1e-3);

  Plant lag;
  lag.amplifier.lag = 0.3e-3;
  PlantMotion one_body(lag, spec, hand);
  EXPECT_LT(imbalance(one_body), 1e-9);

  Mat3 coupled;
  coupled << 0.6, 0.2, 0.0, 0.2, 0.5, -0.1, 0.0, -0.1, 0.4;
  spec.damping = Damping(coupled);
  PlantMotion matrix(with_transmission(15e3, 1.0, 0.03), spec, hand);
  EXPECT_LT(imbalance(matrix), 1e-9);
}

/// Energy balance at the hand: the hand gets the motor's energy minus the energy that the device
/// stores and dissipates.
TEST(PlantMotion, TheHandGetsWhatTheDeviceDoesNotKeep) {
  DeviceSpec spec = smooth_spec();
  spec.damping = 0.4;
  Plant plant = with_transmission(8e3, 0.0, 0.02);
  const Hand hand{.mass = 0.05, .damping = 2.0, .stiffness = 200.0};
  PlantMotion motion(plant, spec, hand);
  shake(motion, 0.5);
  const Vec3 squeezed = motion.motor_position() - motion.handle_position();
  const double kept = 0.5 * 0.06 * motion.motor_velocity().squaredNorm() +
                      0.5 * 0.02 * motion.handle_velocity().squaredNorm() +
                      0.5 * 8e3 * squeezed.squaredNorm();
  const PlantFlow& f = motion.flow();
  EXPECT_NEAR(f.to_hand, f.given - f.burned - kept, 1e-10 * (std::abs(f.given) + f.burned));
}

TEST(PlantMotion, AnUndampedPlantKeepsItsEnergy) {
  PlantMotion motion(with_transmission(10e3, 0.0, 0.02), smooth_spec(),
                     {.mass = 0.02, .damping = 0.0, .stiffness = 100.0});
  motion.write(0.0, Vec3(3, 0, 0));
  run(motion, 0.0, kTick);
  motion.write(kTick, Vec3::Zero());
  const double stored = motion.stored();
  run(motion, kTick, 3.0);
  EXPECT_NEAR(motion.stored(), stored, 1e-9 * stored);
}

TEST(PlantMotion, ReflexesPullByTheErrorOfTheirDelayAgo) {
  Plant plant;
  plant.hand.reflex_delay = 0.05;
  plant.hand.reflex_stiffness = 40.0;
  // Without its own stiffness, the hand does not move before its reflexes act.
  PlantMotion motion(plant, smooth_spec(), {.mass = 0.02, .damping = 0.0, .stiffness = 0.0});
  const Vec3 intended(0.01, 0, 0);
  run(motion, 0.0, 0.0499, intended);
  EXPECT_EQ(motion.handle_position(), Vec3::Zero());
  run(motion, 0.0499, 0.0101, intended);
  // A constant force of 40 N/m times 10 mm acts for 10 ms on 0.1 kg.
  EXPECT_NEAR(motion.handle_position().x(), 0.5 * 4.0 * 0.01 * 0.01, 0.03 * 2e-4);
}

TEST(PlantMotion, AGripThatTightensHoldsMoreFirmly) {
  Plant plant;
  plant.hand.grip = {{1.0, 1.0}, {2.0, 4.0}};
  PlantMotion motion(plant, smooth_spec(), {.mass = 0.1, .damping = 5.0, .stiffness = 100.0});
  motion.write(0.0, Vec3(2, 0, 0));
  run(motion, 0.0, 1.0);
  EXPECT_NEAR(motion.handle_position().x(), 2.0 / 100.0, 1e-6);
  run(motion, 1.0, 2.0);
  EXPECT_NEAR(motion.handle_position().x(), 2.0 / 400.0, 1e-6);
  EXPECT_GT(motion.flow().by_arm, 0.0);  // The arm does work to tighten the grip.
}

TEST(PlantMotion, ThePadGivesBetweenHandleAndHand) {
  Plant plant;
  plant.hand.pad_stiffness = 1000.0;
  plant.hand.pad_damping = 3.0;
  PlantMotion motion(plant, smooth_spec(), {.mass = 0.05, .damping = 5.0, .stiffness = 250.0});
  motion.write(0.0, Vec3(0, 2, 0));
  run(motion, 0.0, 3.0);
  EXPECT_NEAR(motion.hand_position().y(), 2.0 / 250.0, 1e-7);
  EXPECT_NEAR(motion.handle_position().y() - motion.hand_position().y(), 2.0 / 1000.0, 1e-7);
  // A hand without mass is only a spring, so hand and handle have one position.
  PlantMotion tether(plant, smooth_spec(), {.mass = 0.0, .damping = 0.0, .stiffness = 30.0});
  EXPECT_EQ(&tether.hand_position(), &tether.handle_position());
}

TEST(PlantMotion, NothingAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  DeviceSpec spec = smooth_spec();
  spec.coulomb_friction = 0.1;
  PlantMotion motion(rich_plant(), spec, {.mass = 0.05, .damping = 2.0, .stiffness = 200.0});
  const std::size_t before = test::allocations();
  shake(motion, 0.3);
  motion.measured();
  EXPECT_EQ(test::allocations(), before);
}

TEST(PlantMotion, APartThatMovesTooFastIsRefused) {
  EXPECT_THAT(
      [] { PlantMotion(with_transmission(1e9, 0.0, 1e-6), smooth_spec(), kNoHand); },
      ::testing::ThrowsMessage<PlantError>(::testing::AllOf(
          ::testing::HasSubstr("transmission.stiffness"), ::testing::HasSubstr("heavier handle"))));
}

}  // namespace
}  // namespace feltwire::plant_motion_test
