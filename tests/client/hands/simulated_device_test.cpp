#include "client/hands/simulated_device.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace feltwire::simulated_device_test {
namespace {

using std::chrono::milliseconds;

/// Returns a device without friction and quantization. The arm's spring holds the device at the
/// origin.
SimulatedHandOptions still_hand() {
  SimulatedHandOptions o;
  o.spec = builtin_device("simulated");
  o.spec.damping = 0.0;
  o.spec.coulomb_friction = 0.0;
  o.spec.position_resolution = 0.0;
  o.spec.max_force = 10.0;
  o.task.path = HandPath::press;
  o.task.clearance = 0.0;
  o.task.depth = 0.0;
  return o;
}

void run(SimulatedDevice& device, const Vec3& force, int from_ms, int to_ms) {
  for (int ms = from_ms; ms <= to_ms; ++ms) {
    device.read(milliseconds(ms));
    device.write({force, Vec3::Zero(), Vec3::Zero()});
  }
}

TEST(SimulatedDevice, RestsWhereArmAndForceBalance) {
  SimulatedDevice device(still_hand());
  run(device, {3.0, 0.0, -1.5}, 0, 4000);
  EXPECT_NEAR(device.true_position().x(), 3.0 / 300.0, 1e-9);
  EXPECT_NEAR(device.true_position().z(), -1.5 / 300.0, 1e-9);
  EXPECT_NEAR(device.true_velocity().norm(), 0.0, 1e-9);
}

TEST(SimulatedDevice, SwingsWithThePeriodOfAMassOnASpring) {
  SimulatedHandOptions o = still_hand();
  o.hand.damping = 0.0;
  SimulatedDevice device(o);
  run(device, {1.0, 0.0, 0.0}, 0, 0);
  // A force step makes the mass oscillate about f/k: x = f/k (1 - cos(w t)).
  const double w = std::sqrt(o.hand.stiffness / (o.hand.mass + o.spec.apparent_mass));
  for (int ms = 1; ms <= 1000; ++ms) {
    device.read(milliseconds(ms));
    EXPECT_NEAR(device.true_position().x(), (1.0 - std::cos(w * ms * 1e-3)) / 300.0, 2e-5)
        << ms << " ms";
  }
}

TEST(SimulatedDevice, CoulombFrictionHoldsAndNeverTurnsTheMassRound) {
  SimulatedHandOptions o = still_hand();
  o.spec.coulomb_friction = 0.1;
  o.hand.stiffness = 0.0;
  o.hand.damping = 0.0;
  SimulatedDevice device(o);
  run(device, {0.099, 0.0, 0.0}, 0, 500);
  EXPECT_EQ(device.true_position().x(), 0.0) << "below Coulomb friction nothing moves";
  run(device, {0.2, 0.0, 0.0}, 501, 600);
  const double speed = device.true_velocity().x();
  const double mass = o.spec.apparent_mass + o.hand.mass;
  // The force that was written at 501 ms acts during the next 99 ms.
  EXPECT_NEAR(speed, 0.1 / mass * 0.099, 1e-9) << "the excess accelerates";
  run(device, Vec3::Zero(), 601, 2000);
  EXPECT_EQ(device.true_velocity().x(), 0.0);
}

TEST(SimulatedDevice, ReadsWholeEncoderQuanta) {
  SimulatedHandOptions o = still_hand();
  o.spec.position_resolution = 23e-6;
  SimulatedDevice device(o);
  device.read(milliseconds(0));
  device.write({{1.0, 0.7, -0.3}, Vec3::Zero(), Vec3::Zero()});
  for (int ms = 1; ms < 200; ++ms) {
    const Vec3 measured = device.read(milliseconds(ms)).pose.position;
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(std::remainder(measured[i], 23e-6), 0.0, 1e-15);
      EXPECT_LE(std::abs(measured[i] - device.true_position()[i]), 11.5e-6 + 1e-12);
    }
  }
}

TEST(SimulatedDevice, HoldsNoMoreThanItsMotorsCan) {
  SimulatedDevice device(still_hand());
  const Command held = device.write({{30.0, 0.0, 0.0}, {0.0, 40.0, 0.0}, {1.0, 0.0, 0.0}});
  EXPECT_NEAR(held.force().norm(), 10.0, 1e-12);
  EXPECT_NEAR(held.frictional.y() / held.elastic.x(), 4.0 / 3.0, 1e-12) << "direction is kept";
  EXPECT_EQ(held.torque, Vec3::Zero()) << "this device has no torque";
  const Command nonsense = device.write({{std::nan(""), 0.0, 0.0}, Vec3::Zero(), Vec3::Zero()});
  EXPECT_EQ(nonsense.force(), Vec3::Zero());
}

TEST(SimulatedDevice, TwoDegreesOfFreedomStayInTheirPlane) {
  SimulatedHandOptions o = still_hand();
  o.spec.translation_dof = 2;
  o.task.depth = 0.05;  // The arm still has a target along z.
  SimulatedDevice device(o);
  run(device, {1.0, 1.0, 5.0}, 0, 500);
  EXPECT_EQ(device.true_position().z(), 0.0);
  EXPECT_GT(device.true_position().x(), 1e-3);
}

TEST(SimulatedDevice, SameForcesGiveTheSameBits) {
  SimulatedHandOptions o = still_hand();
  o.spec = builtin_device("simulated");
  o.task.path = HandPath::slide;
  o.task.tremor = 1e-4;
  SimulatedDevice a(o), b(o);
  for (int ms = 0; ms < 2000; ++ms) {
    const Command c{{std::sin(ms * 0.01), 0.2, 0.0}, {0.0, 0.0, 0.1}, Vec3::Zero()};
    a.read(milliseconds(ms));
    b.read(milliseconds(ms));
    a.write(c);
    b.write(c);
    ASSERT_EQ(a.true_position(), b.true_position());
  }
  EXPECT_NE(a.true_position(), Vec3::Zero());
}

TEST(SimulatedDevice, RefusesAMasslessHand) {
  SimulatedHandOptions o = still_hand();
  o.spec.apparent_mass = 0.0;
  o.hand.mass = 0.0;
  EXPECT_THAT([&] { SimulatedDevice d(o); }, ::testing::ThrowsMessage<std::invalid_argument>(
                                                 ::testing::HasSubstr("mass above zero")));
}

}  // namespace
}  // namespace feltwire::simulated_device_test
