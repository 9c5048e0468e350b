// Tests a device behind a mapping: its positions, forces, specification and energy.

#include "client/device/mapped_device.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <random>

#include "client/hands/simulated_device.hpp"
#include "tests/devices/mapped_handle.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::mapped_device_test {
namespace {

using ::testing::AllOf;
using testing::any_mapping;
using testing::Handle;
using ::testing::HasSubstr;
using testing::kTick;
using testing::Mapped;

constexpr double kQuarter = 0.5 * std::numbers::pi;

TEST(MappedDevice, WithoutAMappingEverythingIsTheDevicesBitByBit) {
  Mapped mapped({});
  Handle alone;
  EXPECT_EQ(mapped.device.spec().damping, alone.spec().damping);
  EXPECT_EQ(mapped.device.spec().position_resolution, alone.spec().position_resolution);
  EXPECT_EQ(mapped.device.spec().workspace, alone.spec().workspace);
  const Command command{.elastic = Vec3(0.1, -0.2, 0.3), .frictional = Vec3(0.01, 0.02, 0.07)};
  for (int n = 0; n < 1000; ++n) {
    const DeviceReading here = mapped.device.read({}), there = alone.read({});
    EXPECT_EQ(here.pose.position, there.pose.position);
    EXPECT_EQ(mapped.device.write(command), command);
    EXPECT_EQ(mapped.handle->on_hand, command);
    alone.write(command);
  }
}

TEST(MappedDevice, PlacesAndForcesAreThoseOfTheMapping) {
  Mapped mapped({.scale = 2.0, .rotation = kQuarter * Vec3::UnitZ(), .translation = {1, 0, 0}});
  mapped.handle->mass.position = {0.01, 0.02, 0.03};
  mapped.handle->mass.stiffness = mapped.handle->mass.hand_damping = 0.0;
  EXPECT_NEAR((mapped.device.read({}).pose.position - Vec3(1 - 0.04, 0.02, 0.06)).norm(), 0.0,
              5e-5);
  mapped.device.write({.elastic = Vec3(0, 1, 0)});
  EXPECT_EQ(mapped.handle->on_hand.force(), Vec3(2, 0, 0));
  mapped.device.write({.elastic = Vec3(0, 100, 0)});
  EXPECT_EQ(mapped.handle->on_hand.force(), Vec3(8, 0, 0));
  EXPECT_NEAR((mapped.device.write({.elastic = Vec3(0, 100, 0)}).force() - Vec3(0, 4, 0)).norm(),
              0.0, 1e-12);
}

/// Both ports must have equal power of force and torque under any mapping.
TEST(MappedDevice, PowerIsTheSameOnBothSides) {
  std::mt19937 random(19);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (int n = 0; n < 300; ++n) {
    const WorkspaceMapping mapping = any_mapping(random);
    struct Free final : Device {
      DeviceSpec described = builtin_device("simulated_6dof");
      Pose pose;
      Command given;
      const DeviceSpec& spec() const override { return described; }
      DeviceReading read(Nanoseconds) noexcept override { return {.pose = pose}; }
      Command write(const Command& c) noexcept override { return given = c; }
      void release() noexcept override {}
    };
    auto* free = new Free;
    MappedDevice device(std::unique_ptr<Device>(free), mapping);
    const auto vector = [&] { return Vec3(part(random), part(random), part(random)); };
    free->pose = {vector(), turned(Quaternion::Identity(), vector())};
    const Pose before = device.read({}).pose;
    const Vec3 moved = 0.1 * vector(), rotated = vector();
    free->pose = {free->pose.position + moved, turned(free->pose.orientation, rotated)};
    const Pose after = device.read({}).pose;
    const Command c{
        .elastic = 0.1 * vector(), .frictional = 0.1 * vector(), .torque = 0.1 * vector()};
    device.write(c);
    EXPECT_NEAR(c.force().dot(after.position - before.position), free->given.force().dot(moved),
                1e-12);
    EXPECT_NEAR(c.torque.dot(rotation_between(before.orientation, after.orientation)),
                free->given.torque.dot(rotated), 1e-12);
    EXPECT_NEAR(after.orientation.norm(), 1.0, 1e-12);
  }
}

/// The account's numbers must never exceed the device's in any direction.
TEST(MappedDevice, TheNumbersOfTheDeviceAreThoseOfItsTruePort) {
  std::mt19937 random(20);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (int n = 0; n < 300; ++n) {
    WorkspaceMapping mapping = any_mapping(random);
    DeviceSpec spec = builtin_device("simulated_6dof");
    spec.damping = Vec3(0.2, 0.5, 0.9);
    spec.hand_speed = 2.0;
    const DeviceSpec in_scene = mapped_spec(spec, mapping);
    const double s = mapping.scale;
    const Vec3 moved(part(random), part(random), part(random));  // movement of the device
    const Vec3 seen = s * mapping.axes() * moved;
    EXPECT_NEAR(in_scene.damping.quadratic(seen), spec.damping.quadratic(moved), 1e-9);
    EXPECT_NEAR(in_scene.least_friction * seen.norm(), spec.least_friction * moved.norm(), 1e-12);
    EXPECT_NEAR(in_scene.least_mass * seen.squaredNorm(), spec.least_mass * moved.squaredNorm(),
                1e-12);
    EXPECT_NEAR(in_scene.max_force * s, spec.max_force, 1e-12);
    EXPECT_NEAR(in_scene.hand_force * s, spec.hand_force, 1e-12);
    EXPECT_NEAR(in_scene.hand_speed, 2.0 * s, 1e-12);
    // The error is half a quantum along each device axis.
    const Vec3 error = s * mapping.axes() * (0.5 * spec.position_resolution * moved.cwiseSign());
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 0.5 * in_scene.position_resolution * (1.0 + 1e-12));
    EXPECT_LE(
        (s * mapping.axes() * (0.5 * moved.cwiseProduct(spec.workspace))).cwiseAbs().maxCoeff(),
        0.5 * in_scene.workspace.maxCoeff());
  }
  DeviceSpec plain = builtin_device("simulated");
  plain.damping = Vec3(0.2, 0.5, 0.9);
  const DeviceSpec turned_quarter = mapped_spec(plain, {.rotation = kQuarter * Vec3::UnitZ()});
  EXPECT_EQ(turned_quarter.damping, Damping(Vec3(0.5, 0.2, 0.9)));
  EXPECT_EQ(turned_quarter.position_resolution, plain.position_resolution);
}

TEST(MappedDevice, APlaneThatIsTurnedOutOfItselfHasThreeAxes) {
  DeviceSpec plane = builtin_device("simulated");
  plane.translation_dof = 2;
  EXPECT_EQ(mapped_spec(plane, {.rotation = kQuarter * Vec3::UnitZ()}).translation_dof, 2);
  EXPECT_EQ(mapped_spec(plane, {.mirrored_axis = 2}).translation_dof, 2);
  EXPECT_EQ(mapped_spec(plane, {.rotation = kQuarter * Vec3::UnitX()}).translation_dof, 3);
  SimulatedHandOptions options;
  options.spec = plane;
  MappedDevice device(std::make_unique<SimulatedDevice>(options),
                      {.rotation = kQuarter * Vec3::UnitX()});
  device.read({});
  // The device's y axis is the scene's z axis. The device has no force along the scene's y axis.
  const Command held = device.write({.elastic = Vec3(0.1, 0.2, 0.3)});
  EXPECT_NEAR((held.force() - Vec3(0.1, 0.0, 0.3)).norm(), 0.0, 1e-15);
}

TEST(MappedDevice, AScaleThatTheDeviceCannotHaveIsRefused) {
  DeviceSpec heavy = builtin_device("simulated");
  heavy.damping = 1.0;
  try {
    mapped_spec(heavy, {.scale = 0.01});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("map_scale of --device 0.01"), HasSubstr("damping"),
                                    HasSubstr("nearer to 1")));
  }
}

/// A simulated hand must begin at the scene's start and return to it through the mapping.
TEST(MappedDevice, BeginsWhereTheSceneSays) {
  std::mt19937 random(3);
  for (int n = 0; n < 50; ++n) {
    SimulatedHandOptions options;
    options.spec = builtin_device("simulated");
    options.spec.position_resolution = 0.0;
    options.task.clearance = 0.0;
    options.own_center = options.own_normal = false;
    MappedDevice device(std::make_unique<SimulatedDevice>(options), any_mapping(random));
    const Vec3 place(0.1, -0.2, 0.3);
    device.begin(place, Vec3(0, 0.6, 0.8));
    EXPECT_NEAR((device.read({}).pose.position - place).norm(), 0.0, 1e-9);
  }
}

/// Returns the excess [J] of the handle's true energy over the dissipated energy, in ten seconds at
/// a late wall.
double made(const WorkspaceMapping& mapping, std::string_view mode, std::size_t lag = 0,
            bool told_wrong = false, bool tells_lag = true, bool tells_held = true) {
  Mapped mapped(mapping, mode, told_wrong, lag, tells_lag);
  mapped.handle->tells_held = tells_held;
  mapped.run(10.0);
  EXPECT_GT(mapped.handle->mass.largest_force, 0.3);
  return mapped.handle->mass.most_made;
}

TEST(MappedDevice, MakesNoEnergyAtTheTruePortWhateverTheMapping) {
  std::mt19937 random(7);
  for (int n = 0; n < test::rounds(40); ++n) {
    const WorkspaceMapping mapping = any_mapping(random);
    EXPECT_LE(made(mapping, kSessionMethod, n % 3), 1e-12)
        << n << " scale " << mapping.scale << " turned " << mapping.rotation.transpose();
  }
}

/// The device reports its delay, but not the held force: write() returns its argument.
TEST(MappedDevice, NorWhereTheDeviceCannotTellWhatItHolds) {
  std::mt19937 random(8);
  for (int n = 0; n < test::rounds(20); ++n) {
    const WorkspaceMapping mapping = any_mapping(random);
    EXPECT_LE(made(mapping, kSessionMethod, 1 + n % 4, false, true, false), 1e-12)
        << n << " scale " << mapping.scale << " turned " << mapping.rotation.transpose();
  }
}
/// The measurement can fail: without a bound, with unmapped numbers of the device, and with a
/// device that hides its delay.
TEST(MappedDevice, TheWallAloneOrNumbersThatAreNotMappedWouldMakeEnergy) {
  EXPECT_GT(made({.scale = 3.0}, kUnbounded), 0.005);
  EXPECT_GT(made({.scale = 3.0}, kSessionMethod, 0, true), 1e-4);
  EXPECT_GT(made({.scale = 6.0}, kSessionMethod, 2, false, false), 1e-4);
}

TEST(MappedDevice, ReleaseReachesTheDevice) {
  Mapped mapped({.scale = 2.0});
  mapped.feel(1.0);
  mapped.device.release();
  mapped.tick();
  EXPECT_EQ(mapped.handle->on_hand, Command{});
  EXPECT_EQ(mapped.servo.held(), Command{});
}

TEST(MappedDevice, ATickDoesNotTouchTheHeap) {
  Mapped mapped({.scale = 2.0, .rotation = Vec3(0.1, 0.2, 0.3)});
  mapped.run(0.1);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) {
    mapped.handle->clutch = n / 100 % 2 == 1;
    mapped.servo.tick(mapped.device, mapped.now += from_seconds(kTick));
  }
  EXPECT_EQ(test::allocations() - before, 0u);
}

}  // namespace
}  // namespace feltwire::mapped_device_test
