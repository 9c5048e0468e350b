// Tests a device that applies forces late and does not report the held force. The device declares
// the delay as late_ticks instead. Eight hands press walls of 5 and 40 kN/m, and the test measures
// the energy at the true port.

#include <gtest/gtest.h>

#include <deque>

#include "client/hands/simulated_device.hpp"
#include "server/scene/session.hpp"
#include "sim/hands/eight_hands.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::late_device_test {
namespace {

using namespace testing::servo;

constexpr double kTick = 1e-3;  // [s]

DeviceSpec cable_driven() {
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = 0.005;
  spec.apparent_mass = spec.least_mass = 0.075;
  spec.coulomb_friction = spec.least_friction = 0.04;
  spec.position_resolution = 30e-6;
  spec.max_force = spec.continuous_force = 8.5;
  return spec;
}

struct Wall {
  double stiffness = 5e3;  // [N/m]
  std::string_view mode = "shaped";
  int late = 1;
  bool says_late = true;
};

struct LateDeviceResult {
  // [J] at the true port: largest excess of the delivered over the dissipated energy
  double made = 0.0;
  double largest = 0.0;  // [N] largest force
  std::uint64_t violations = 0;
};

/// A hand presses, slides and taps for some seconds.
LateDeviceResult feel(const DeviceSpec& truth, const Hand& hand, HandPath path, const Wall& wall) {
  DeviceSpec spec = truth;
  spec.actuation.late_ticks = wall.says_late ? wall.late : 0;
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.material.stiffness = wall.stiffness;
  const Scene scene("floor", {floor});
  SessionParameters p = parameters(wall.mode);
  p.local_model = true;
  ServoOptions options;
  options.scene_stiffness = wall.stiffness;
  Servo servo(spec, p, options);
  Session session({"tester", "floor", spec, p}, scene.views().front());
  SimulatedHandOptions how;
  how.spec = truth;
  how.hand = hand;
  how.task.path = path;
  how.task.depth = 3.0 / hand.stiffness + 3.0 / wall.stiffness;
  how.task.frequency = path == HandPath::taps ? 2.0 : 0.5;
  SimulatedDevice device(how);
  std::deque<Command> coming(static_cast<std::size_t>(wall.late));
  Nanoseconds now = seconds(3.0);
  Vec3 before = device.true_position();
  Vec3 force = Vec3::Zero();
  double left = 0.0;
  LateDeviceResult felt;
  for (int n = 0; n < 5000; ++n) {
    now += kPeriod;
    const DeviceReading reading = device.read(now);
    const Vec3 moved = device.true_position() - before;
    before = device.true_position();
    if (n > 0)
      left += spec.damping.quadratic(moved) / kTick + truth.coulomb_friction * moved.lpNorm<1>() -
              force.dot(moved);
    felt.made = std::max(felt.made, -left);
    const Command given = servo.render(reading, now);
    coming.push_back(given);
    force = device.write(coming.front()).force();
    coming.pop_front();
    felt.largest = std::max(felt.largest, force.norm());
    const Sample* sample = servo.hold(given);
    if (sample == nullptr) continue;
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = *sample;
    servo.take(session.take(batch, now).reply, now);
  }
  felt.violations = servo.port().violations();
  return felt;
}

TEST(LateDevice, MakesNoEnergyAtTheTruePortInEightHands) {
  for (const DeviceSpec& device : {builtin_device("simulated"), cable_driven()})
    for (const double stiffness : {5e3, 40e3})
      for (const HandPath path : {HandPath::press, HandPath::slide, HandPath::taps})
        for (const NamedHand& hand : kEightHands) {
          const LateDeviceResult felt = feel(device, hand.hand, path, {.stiffness = stiffness});
          EXPECT_LE(felt.made, 1e-9) << hand.name << ' ' << stiffness << ' ' << device.apparent_mass
                                     << ' ' << static_cast<int>(path);
          EXPECT_GT(felt.largest, 0.2) << hand.name << ' ' << stiffness;
          EXPECT_EQ(felt.violations, 0u) << hand.name << ' ' << stiffness;
        }
}

TEST(LateDevice, NorBehindOtherLawsNorLaterThanThat) {
  for (const std::string_view mode : {"contact_frame", "credited", "midpoint", "energy_tank"})
    for (const NamedHand& hand : kEightHands)
      EXPECT_LE(feel(cable_driven(), hand.hand, HandPath::slide, {.mode = mode}).made, 1e-9)
          << mode << ' ' << hand.name;
  for (const int late : {2, 4})
    for (const NamedHand& hand : kEightHands)
      EXPECT_LE(feel(cable_driven(), hand.hand, HandPath::slide, {.late = late}).made, 1e-9)
          << late << ' ' << hand.name;
}

/// A late device that does not declare its delay must make energy. This shows that the measurement
/// can fail.
TEST(LateDevice, ThatDoesNotSaySoWouldMakeIt) {
  double most = 0.0;
  for (const NamedHand& hand : kEightHands)
    most =
        std::max(most, feel(cable_driven(), hand.hand, HandPath::slide, {.says_late = false}).made);
  EXPECT_GT(most, 1e-3);
}

}  // namespace
}  // namespace feltwire::late_device_test
