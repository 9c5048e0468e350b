// Tests a simulated device with a plant: amplifier, transmission and encoder. An ideal plant must
// match the rig, which is the integration without a plant. The encoder must measure the side that
// the plant specifies.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <vector>

#include "client/drivers/drivers.hpp"
#include "client/hands/plant_file.hpp"
#include "client/hands/simulated_device.hpp"
#include "core/base/file_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::plant_device_test {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Returns a default hand that presses a wall at z = 0. The encoder is not quantized.
SimulatedHandOptions pressing() {
  SimulatedHandOptions o;
  o.spec = builtin_device("simulated");
  o.spec.apparent_mass = 0.08;
  o.spec.position_resolution = 0.0;
  o.task.depth = 0.006;
  return o;
}

/// Returns the force of a wall below z = 0 with 1 kN/m and 2 N s/m.
Vec3 wall(const Vec3& position, const Vec3& before) {
  if (position.z() >= 0.0) return Vec3::Zero();
  return {0.0, 0.0, -1e3 * position.z() - 2.0 * (position.z() - before.z()) / 1e-3};
}

struct Path {
  std::vector<Vec3> handle, motor, read;
  TrueEnergy energy;
};

/// Returns the encoder positions of a hand that presses the wall for two seconds.
Path pressed(SimulatedDevice& device) {
  Path path;
  Vec3 before = device.true_position();
  for (int ms = 0; ms <= 2000; ++ms) {
    const Vec3 read = device.read(milliseconds(ms)).pose.position;
    device.write({wall(read, before), Vec3::Zero(), Vec3::Zero()});
    before = read;
    path.read.push_back(read);
    path.handle.push_back(device.true_position());
    path.motor.push_back(device.motor_position());
  }
  path.energy = device.true_energy();
  return path;
}
Path pressed(const SimulatedHandOptions& options) {
  SimulatedDevice device(options);
  return pressed(device);
}

/// Returns the largest distance [m] between two paths.
double apart(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

TEST(PlantDevice, AnIdealPlantIsTheRigToTheBit) {
  SimulatedHandOptions with = pressing();
  with.plant.name = "ideal";
  with.plant.encoder.side = EncoderSide::handle;
  with.plant.seed = 5;
  ASSERT_TRUE(with.plant.ideal());
  EXPECT_EQ(pressed(with).handle, pressed(pressing()).handle);
}

/// Integrates the same press with PlantMotion. The device uses PlantMotion for plants that are not
/// ideal.
Path pressed_in_motion(const SimulatedHandOptions& o) {
  PlantMotion motion(o.plant, o.spec, o.hand);
  const IntendedMotion task(o.task);
  Vec3 intended = task.position(0.0);
  motion.place(intended);
  Vec3 before = intended;
  Path path;
  constexpr double kTick = 1e-3;
  const int steps = static_cast<int>(std::ceil(kTick / motion.longest_step()));
  const double h = kTick / steps;
  for (int ms = 0; ms <= 2000; ++ms) {
    path.handle.push_back(motion.handle_position());
    path.energy = {.given = motion.flow().given,
                   .burned = motion.flow().burned,
                   .to_hand = motion.flow().to_hand};
    motion.write(ms * kTick, wall(motion.handle_position(), before));
    before = motion.handle_position();
    const Vec3 target = task.position((ms + 1) * kTick);
    const Vec3 velocity = (target - intended) / kTick;
    for (int i = 0; i < steps; ++i)
      motion.step(ms * kTick + i * h, h, intended + i * h * velocity, velocity);
    intended = target;
  }
  return path;
}

TEST(PlantDevice, TheMotionOfAnIdealPlantIsThatOfTheRigToAMicrometre) {
  const Path rig = pressed(pressing()), motion = pressed_in_motion(pressing());
  EXPECT_LT(apart(rig.handle, motion.handle), 1e-6);
  // The hand presses at least 9 mm deep.
  EXPECT_GT(rig.handle.front().z() - rig.handle.back().z(), 9e-3);
  EXPECT_NEAR(motion.energy.given, rig.energy.given, 1e-3 * std::abs(rig.energy.given));
  EXPECT_NEAR(motion.energy.burned, rig.energy.burned, 1e-3 * rig.energy.burned);
  EXPECT_NEAR(motion.energy.to_hand, rig.energy.to_hand, 1e-3 * std::abs(rig.energy.to_hand));
}

/// The rig has a first-order integration error: a fast hand is one step of 20 us ahead. With steps
/// of 1 us, rig and PlantMotion agree. The error therefore belongs to the rig.
TEST(PlantDevice, WhereTheRigDiffersItIsByOneStepOfItsOwn) {
  SimulatedHandOptions o = pressing();
  o.task.path = HandPath::slide;
  o.task.frequency = 1.0;
  const Path motion = pressed_in_motion(o);
  const double speed = o.task.radius * 2.0 * std::numbers::pi * o.task.frequency;
  EXPECT_LT(apart(pressed(o).handle, motion.handle), 20e-6 * speed);
  SimulatedDevice fine(o);
  std::vector<Vec3> handle;
  Vec3 before = fine.true_position();
  for (int us = 0; us <= 2000000; ++us) {
    fine.read(std::chrono::microseconds(us));
    if (us % 1000 != 0) continue;
    handle.push_back(fine.true_position());
    fine.write({wall(handle.back(), before), Vec3::Zero(), Vec3::Zero()});
    before = handle.back();
  }
  EXPECT_LT(apart(handle, motion.handle), 1e-6);
}

TEST(PlantDevice, AStiffTransmissionIsTheRigInTheLimit) {
  const Path rig = pressed(pressing());
  double before = 1.0;
  for (const double stiffness : {1e5, 1e6, 1e7}) {
    SimulatedHandOptions o = pressing();
    o.plant.transmission = {.stiffness = stiffness, .damping = 5.0, .handle_mass = 0.004};
    const double distance = apart(pressed(o).handle, rig.handle);
    EXPECT_LT(distance, before) << stiffness;
    before = distance;
  }
  EXPECT_LT(before, 1e-6);
}

TEST(PlantDevice, AShortLagIsNoneInTheLimit) {
  const Path none = pressed_in_motion(pressing());
  double before = 1.0;
  for (const double lag : {1e-4, 1e-5, 1e-6}) {
    SimulatedHandOptions o = pressing();
    o.plant.amplifier.lag = lag;
    const double distance = apart(pressed(o).handle, none.handle);
    EXPECT_LT(distance, 0.2 * before) << lag;
    before = distance;
  }
  EXPECT_LT(before, 1e-7);
}

TEST(PlantDevice, TheEncoderReadsTheEndWhereItStands) {
  SimulatedHandOptions o = pressing();
  o.plant.transmission = {.stiffness = 5e3, .damping = 2.0, .handle_mass = 0.02};
  const Path at_motor = pressed(o);
  EXPECT_EQ(at_motor.read, at_motor.motor);
  EXPECT_GT(apart(at_motor.motor, at_motor.handle), 1e-4);
  o.plant.encoder.side = EncoderSide::handle;
  const Path at_handle = pressed(o);
  EXPECT_EQ(at_handle.read, at_handle.handle);
  o.spec.position_resolution = 30e-6;
  for (const Vec3& read : pressed(o).read) EXPECT_NEAR(std::remainder(read.z(), 30e-6), 0.0, 1e-12);
}

TEST(PlantDevice, TheEncodersNoiseIsAsLargeAsItIsSaidToBe) {
  SimulatedHandOptions o = pressing();
  o.plant.encoder.noise = 2e-6;
  const Path path = pressed(o);
  double squares = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < path.read.size(); ++i) {
    const Vec3 noise = path.read[i] - path.motor[i];
    squares += noise.squaredNorm();
    sum += noise.sum();
  }
  const double count = 3.0 * static_cast<double>(path.read.size());
  EXPECT_NEAR(std::sqrt(squares / count), 2e-6, 0.05 * 2e-6);
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 2e-6 / std::sqrt(count));
}

TEST(PlantDevice, TwoDegreesOfFreedomStayInTheirPlane) {
  SimulatedHandOptions o = pressing();
  o.spec.translation_dof = 2;
  o.plant.encoder.noise = 2e-6;
  o.plant.transmission = {.stiffness = 5e3, .damping = 2.0, .handle_mass = 0.02};
  const Path path = pressed(o);
  for (std::size_t i = 0; i < path.read.size(); ++i) {
    EXPECT_EQ(path.read[i].z(), 0.0);
    EXPECT_EQ(path.handle[i].z(), 0.0);
  }
}

Plant rich() {
  Plant plant;
  plant.transmission = {.stiffness = 8e3, .damping = 1.5, .backlash = 30e-6, .handle_mass = 0.02};
  plant.amplifier = {.lag = 0.2e-3, .delay = 0.1e-3, .jitter = 0.2e-3, .resolution = 0.008};
  plant.friction = {.breakaway = 0.3, .stribeck_velocity = 2e-3};
  plant.encoder.noise = 1e-6;
  plant.hand.pad_stiffness = 1500.0;
  plant.hand.pad_damping = 2.0;
  return plant;
}

TEST(PlantDevice, TheSameForcesGiveTheSameBits) {
  SimulatedHandOptions o = pressing();
  o.plant = rich();
  const Path first = pressed(o), again = pressed(o);
  EXPECT_EQ(first.read, again.read);
  EXPECT_EQ(first.handle, again.handle);
  EXPECT_EQ(first.energy.given, again.energy.given);
  o.plant.seed = 2;
  EXPECT_NE(pressed(o).read, first.read);
}

TEST(PlantDevice, AReleasedMotorLosesItsForceAsItsAmplifierLetsIt) {
  SimulatedHandOptions o = pressing();
  o.spec.damping = 0.0;
  o.spec.coulomb_friction = 0.0;
  o.hand = kNoHand;
  o.plant.amplifier.lag = 0.5e-3;
  SimulatedDevice device(o);
  device.read(milliseconds(0));
  device.write({Vec3(1, 0, 0), Vec3::Zero(), Vec3::Zero()});
  device.read(milliseconds(20));
  const double speed = device.true_velocity().x();
  device.release();
  device.read(milliseconds(40));
  EXPECT_NEAR(device.true_velocity().x() - speed, 1.0 * 0.5e-3 / 0.08, 1e-9);
  EXPECT_EQ(device.write({Vec3(1, 0, 0), Vec3::Zero(), Vec3::Zero()}).force(), Vec3::Zero());
}

TEST(PlantDevice, ATorqueRisesWithTheSameLag) {
  SimulatedHandOptions o;
  o.spec = builtin_device("simulated_6dof");
  o.spec.rotational_damping = 0.0;
  o.spec.rotation.friction = 0.0;
  o.spec.rotation.inertia = 1e-4;
  o.hand = kNoHand;
  o.plant.amplifier.lag = 1e-3;
  SimulatedDevice device(o);
  device.read(milliseconds(0));
  device.write({.torque = Vec3(0, 0, 0.01)});
  for (int ms = 1; ms <= 10; ++ms) {
    device.read(milliseconds(ms));
    const double t = 1e-3 * ms;
    EXPECT_NEAR(device.true_angular_velocity().z(),
                0.01 / 1e-4 * (t - 1e-3 * (1.0 - std::exp(-t / 1e-3))), 1e-9)
        << ms << " ms";
  }
  EXPECT_GT(device.true_energy().given, 0.0);
}

TEST(PlantDevice, TheMotorsEnergyIsThatOfItsTrueForce) {
  for (const double lag : {0.0, 2e-3}) {
    SimulatedHandOptions o = pressing();
    o.spec.damping = 0.0;
    o.spec.coulomb_friction = 0.5;
    o.hand = kNoHand;
    o.plant.amplifier.lag = lag;
    SimulatedDevice device(o);
    device.read(milliseconds(0));
    const Vec3 start = device.true_position();
    device.write({Vec3(1.5, 0, 0), Vec3::Zero(), Vec3::Zero()});
    device.read(milliseconds(100));
    device.write({});
    device.read(milliseconds(2000));
    const double way = (device.true_position() - start).x();
    const TrueEnergy energy = device.true_energy();
    // At rest the device has dissipated all energy. When the force ended, the mass still had most
    // of the energy.
    EXPECT_NEAR(energy.burned, 0.5 * way, 1e-9);
    EXPECT_NEAR(energy.given, energy.burned, 1e-3 * energy.burned);
    EXPECT_NEAR(energy.made, 0.5 * 1.0 * 1.0 / 0.08 * 0.1 * 0.1, 0.05 * energy.made);
    EXPECT_NEAR(energy.to_hand, 0.0, 1e-3 * energy.burned);
  }
}

TEST(PlantDevice, AHandInThePlantReplacesTheUsualOne) {
  SimulatedHandOptions o = pressing();
  o.plant.hand.mass = 0.02;
  o.plant.hand.damping = 0.5;
  o.plant.hand.stiffness = 50.0;
  SimulatedHandOptions light = pressing();
  light.hand = with_wrist({.mass = 0.02, .damping = 0.5, .stiffness = 50.0});
  EXPECT_EQ(pressed(o).handle, pressed(light).handle);
}

TEST(PlantDevice, APlantThatDoesNotFitItsDeviceIsRefused) {
  const auto refuse = [](const Plant& plant) {
    SimulatedHandOptions o = pressing();
    o.plant = plant;
    SimulatedDevice device(o);
  };
  Plant heavy;
  heavy.transmission = {.stiffness = 1e4, .handle_mass = 0.08};
  EXPECT_THAT([&] { refuse(heavy); },
              ThrowsMessage<PlantError>(AllOf(HasSubstr("transmission.handle_mass"),
                                              HasSubstr("0.08"), HasSubstr("give less"))));
  Plant slippery;
  slippery.friction = {.breakaway = 0.01, .stribeck_velocity = 1e-3};
  EXPECT_THAT([&] { refuse(slippery); },
              ThrowsMessage<PlantError>(
                  AllOf(HasSubstr("friction.breakaway"), HasSubstr("give as much or more"))));
}

// Tests of plant files.

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

TEST(PlantFile, GivesEveryNumberOfThePlant) {
  const test::TemporaryFolder folder;
  const auto file = folder / "plant.json";
  write(file, R"({
    "name": "all", "sources": "a test", "seed": 9,
    "amplifier": {"lag": 1e-4, "delay": 2e-4, "jitter": 3e-4, "resolution": 0.01},
    "transmission": {"stiffness": 12000, "damping": 1.5, "backlash": 3e-5, "handle_mass": 0.02},
    "friction": {"breakaway": 0.2, "stribeck_velocity": 0.002},
    "encoder": {"side": "handle", "noise": 1e-6},
    "hand": {"mass": 0.02, "damping": 0.5, "stiffness": 50, "pad_stiffness": 2000,
             "pad_damping": 2, "reflex_delay": 0.05, "reflex_stiffness": 20,
             "reflex_damping": 0.1, "grip": [{"time": 1, "share": 2}, {"time": 2}]}})");
  const Plant plant = load_plant(file);
  EXPECT_EQ(plant.name, "all");
  EXPECT_EQ(plant.seed, 9u);
  EXPECT_EQ(plant.amplifier.lag, 1e-4);
  EXPECT_EQ(plant.amplifier.delay, 2e-4);
  EXPECT_EQ(plant.amplifier.jitter, 3e-4);
  EXPECT_EQ(plant.amplifier.resolution, 0.01);
  EXPECT_EQ(plant.transmission.stiffness, 12000.0);
  EXPECT_EQ(plant.transmission.damping, 1.5);
  EXPECT_EQ(plant.transmission.backlash, 3e-5);
  EXPECT_EQ(plant.transmission.handle_mass, 0.02);
  EXPECT_EQ(plant.friction.breakaway, 0.2);
  EXPECT_EQ(plant.friction.stribeck_velocity, 0.002);
  EXPECT_EQ(plant.encoder.side, EncoderSide::handle);
  EXPECT_EQ(plant.encoder.noise, 1e-6);
  EXPECT_EQ(plant.hand.mass, 0.02);
  EXPECT_EQ(plant.hand.damping, 0.5);
  EXPECT_EQ(plant.hand.stiffness, 50.0);
  EXPECT_EQ(plant.hand.pad_stiffness, 2000.0);
  EXPECT_EQ(plant.hand.pad_damping, 2.0);
  EXPECT_EQ(plant.hand.reflex_delay, 0.05);
  EXPECT_EQ(plant.hand.reflex_stiffness, 20.0);
  EXPECT_EQ(plant.hand.reflex_damping, 0.1);
  ASSERT_EQ(plant.hand.grip.size(), 2u);
  EXPECT_EQ(plant.hand.grip[0].share, 2.0);
  EXPECT_EQ(plant.hand.grip[1].share, 1.0);
  write(file, "{}");
  EXPECT_TRUE(load_plant(file).ideal());
}

TEST(PlantFile, AnErrorNamesFileLineFieldAndRemedy) {
  const test::TemporaryFolder folder;
  const auto file = folder / "plant.json";
  const auto refused = [&](const std::string& text, const std::string& field,
                           const std::string& says) {
    write(file, text);
    EXPECT_THAT([&] { load_plant(file); },
                ThrowsMessage<FileError>(
                    AllOf(HasSubstr("plant.json:"), HasSubstr(field), HasSubstr(says))))
        << text;
  };
  refused("{\n \"amplifier\": {\"lag\": -1}}", ":2: amplifier.lag", "check the unit");
  refused(R"({"amplifier": {"delay": 3}})", "amplifier.delay", "from 0 to 0.05 s");
  refused(R"({"amplifier": {"jitter": 3}})", "amplifier.jitter", "check the unit");
  refused(R"({"amplifier": {"resolution": -1}})", "amplifier.resolution", "check the unit");
  refused(R"({"amplifier": {"kind": "filter"}})", "kind", "the fields are: lag");
  refused(R"({"transmission": {"handle_mass": 0.02}})", "transmission", "leave the transmission");
  refused(R"({"transmission": {"stiffness": 0, "handle_mass": 0.02}})", "transmission.stiffness",
          "rigid");
  refused(R"({"transmission": {"stiffness": 1e4}})", "transmission", "behind the transmission");
  refused(R"({"transmission": {"stiffness": 1e4, "handle_mass": 0}})", "transmission.handle_mass",
          "above 0 kg");
  refused(R"({"transmission": {"stiffness": 1e4, "handle_mass": 0.1, "backlash": 1}})",
          "transmission.backlash", "check the unit");
  refused(R"({"friction": {"stribeck_velocity": 0.1}})", "friction", "leave friction out");
  refused(R"({"friction": {"breakaway": 0.1}})", "friction", "for example 0.001");
  refused(R"({"encoder": {"side": "wrist"}})", "encoder.side", "motor handle");
  refused(R"({"encoder": {"noise": 1}})", "encoder.noise", "check the unit");
  refused(R"({"hand": {"pad_damping": 1}})", "hand", "leave both out");
  refused(R"({"hand": {"pad_stiffness": -1}})", "hand.pad_stiffness", "leave it out");
  refused(R"({"hand": {"reflex_stiffness": 1}})", "hand", "from 0.001 to 0.2 s");
  refused(R"({"hand": {"grip": [{"time": 2}, {"time": 2}]}})", "hand.grip[1]", "rising");
  refused(R"({"hand": {"grip": [{"time": 2, "share": -1}]}})", "hand.grip[0].share", "share");
  refused(R"({"hand": {"mass": -1}})", "hand.mass", "check the unit");
  refused("{\"lag\": 1}", "lag", "the fields are: name");
  EXPECT_THAT([&] { load_plant(folder / "none.json"); },
              ThrowsMessage<FileError>(HasSubstr("none.json")));
}

DeviceRequest requesting(const std::string& plant, const std::string& spec) {
  DeviceRequest request;
  request.name = "plant=" + plant;
  request.spec.name_or_file = spec;
  return request;
}

TEST(PlantFile, TheDriverOpensTheShippedExamples) {
  const DriverChoice simulated = chosen_driver("simulated");
  std::size_t opened = 0;
  for (const auto& file : test::files_in(FELTWIRE_SOURCE_DIR "/examples/plants")) {
    const OpenedDevice device =
        simulated.driver->open(requesting(file.string(), "phantom_premium_1.5"));
    for (int ms = 0; ms < 200; ++ms) {
      const Vec3 at = device.device->read(milliseconds(ms)).pose.position;
      ASSERT_TRUE(at.allFinite()) << file;
      device.device->write({.elastic = Vec3(0, 0, 1)});
    }
    EXPECT_GT(device.true_energy().burned, 0.0) << file;
    ++opened;
  }
  EXPECT_GE(opened, 3u);
}

TEST(PlantFile, ThePlantOfADeviceThatNobodyHoldsHasNoHand) {
  DeviceRequest request =
      requesting(FELTWIRE_SOURCE_DIR "/examples/plants/light_grip.json", "phantom_premium_1.5");
  request.held = false;
  const OpenedDevice opened = chosen_driver("simulated").driver->open(request);
  opened.device->read(milliseconds(0));
  opened.device->write({.elastic = Vec3(1, 0, 0)});
  opened.device->read(milliseconds(1000));
  // The handle moves without resistance.
  EXPECT_GT(opened.device->read(milliseconds(1001)).pose.position.x(), 0.5);
}

TEST(PlantFile, TheDriverNamesTheFileOfAPlantThatDoesNotFit) {
  const test::TemporaryFolder folder;
  const auto file = folder / "plant.json";
  write(file, R"({"transmission": {"stiffness": 1e4, "handle_mass": 5}})");
  EXPECT_THAT(
      [&] { chosen_driver("simulated").driver->open(requesting(file.string(), "simulated")); },
      ThrowsMessage<FileError>(
          AllOf(HasSubstr("plant.json: transmission.handle_mass"), HasSubstr("give less"))));
}

}  // namespace
}  // namespace feltwire::plant_device_test
