// Tests the clutch of a mapped device. While the clutch is pressed, the hand moves without the
// tool.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/devices/mapped_handle.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::clutch_test {
namespace {

using testing::any_mapping;
using testing::Handle;
using testing::Mapped;
using testing::vec;

TEST(Clutch, TheToolStandsWhileItIsHeldAndGoesOnFromExactlyThere) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> ticks(2, 400);
  for (int n = 0; n < 20; ++n) {
    // If a device hid its delay, the account would soon have a debt that ends the force.
    Mapped mapped(any_mapping(random), kSessionMethod, false, static_cast<std::size_t>(n % 3));
    Handle& handle = *mapped.handle;
    for (int turn = 0; turn < 8; ++turn) {
      for (int left = ticks(random); left > 0; --left) mapped.tick();
      handle.orientation = turned(handle.orientation, Vec3(0.1, 0.2, -0.3));
      mapped.tick();
      handle.clutch = true;
      mapped.run(0.008);  // A late device may hold its force for some ticks.
      const Pose stands = mapped.tool;
      const Vec3 hand = vec(handle.mass.position);
      for (int left = 100 + ticks(random); left > 0; --left) {
        handle.orientation = turned(handle.orientation, Vec3(-1e-3, 1e-3, 2e-3));
        mapped.tick();
        EXPECT_EQ(mapped.tool.position, stands.position);
        EXPECT_EQ(mapped.tool.orientation.coeffs(), stands.orientation.coeffs());
        EXPECT_EQ(handle.on_hand, Command{});
        EXPECT_EQ(mapped.servo.no_force(), ZeroForceReason::clutched);
      }
      EXPECT_GT((vec(handle.mass.position) - hand).norm(), 1e-4);
      handle.clutch = false;
      mapped.tick();
      EXPECT_EQ(mapped.tool.position, stands.position);
      EXPECT_EQ(mapped.tool.orientation.coeffs(), stands.orientation.coeffs());
      EXPECT_NE(mapped.servo.no_force(), ZeroForceReason::clutched);
    }
    EXPECT_EQ(mapped.servo.statistics().device.faults, 0u);
  }
}

/// The clutch is released while the hand presses the wall. The force must then grow only with
/// further depth, until the hand has left the wall once.
TEST(Clutch, IsLetGoWithoutAKick) {
  Mapped mapped({.scale = 2.0});
  Handle& handle = *mapped.handle;
  mapped.feel(1.0);
  handle.clutch = true;
  mapped.run(0.01);
  EXPECT_EQ(handle.on_hand, Command{});
  handle.mass.stiffness = 0.0;  // The hand rests.
  handle.mass.hand_damping = 50.0;
  mapped.run(0.5);
  handle.clutch = false;
  double most = 0.0;
  for (int n = 0; n < 500; ++n) {
    mapped.tick();
    most = std::max(most, handle.on_hand.force().norm());
  }
  EXPECT_LT(most, 0.05);
  EXPECT_EQ(mapped.servo.no_force(), ZeroForceReason::waiting);
  handle.mass.stiffness = 200.0;
  handle.mass.hand_damping = 2.0;
  mapped.feel(0.5);
}

/// The clutch toggles as fast as a finger can, at every phase of the taps. The test also uses a
/// device that applies forces late.
TEST(Clutch, MakesNoEnergyHoweverOftenItIsPressed) {
  std::mt19937 random(13);
  std::uniform_int_distribution<int> ticks(1, 60);
  for (int n = 0; n < test::rounds(12); ++n) {
    Mapped mapped(any_mapping(random));
    Handle& handle = *mapped.handle;
    handle.lag = static_cast<std::size_t>(n % 2);
    double felt = 0.0;
    for (int turn = 0; turn < 400; ++turn) {
      // Some phases are long enough to leave the wall and touch it again.
      for (int left = ticks(random) * (turn % 8 == 0 ? 20 : 1); left > 0; --left) mapped.tick();
      felt = std::max(felt, handle.mass.largest_force);
      handle.clutch = !handle.clutch;
    }
    EXPECT_LE(handle.mass.most_made, 1e-12) << n;
    EXPECT_GT(felt, 0.1);
  }
}

/// Checks a session in which the clutch was just pressed. `lag`: ticks until the device releases
/// its force.
void expect_told_while_it_pulls(Mapped& mapped, std::size_t lag) {
  int pulled = 0;
  for (int n = 0; n < 20; ++n) {
    const bool pulls = mapped.handle->on_hand != Command{};
    mapped.tick();
    if (!pulls) continue;
    ++pulled;
    EXPECT_EQ(mapped.tool.position, vec(mapped.handle->mass.sensed())) << lag << ' ' << n;
  }
  EXPECT_GE(pulled, static_cast<int>(lag));
  EXPECT_EQ(mapped.servo.no_force(), ZeroForceReason::clutched);
}

/// The movement must count until the device has released its force, for any duration of the
/// release.
TEST(Clutch, WhatMovesUnderAForceIsTold) {
  for (const std::size_t lag : {0U, 1U, 2U, 5U}) {
    Mapped mapped({});
    mapped.handle->lag = lag;
    mapped.feel(1.0);
    mapped.handle->clutch = true;
    expect_told_while_it_pulls(mapped, lag);
  }
}

/// A device that reports its delay, but not the held force.
TEST(Clutch, WhatMovesUnderAForceOfWhichTheDeviceCannotTellIsTold) {
  for (const std::size_t lag : {1U, 2U, 4U}) {
    Mapped mapped({}, kSessionMethod, false, lag);
    mapped.handle->tells_held = false;
    mapped.feel(1.0);
    mapped.handle->clutch = true;
    expect_told_while_it_pulls(mapped, lag);
  }
}

/// A press of a single tick must count.
TEST(Clutch, APressThatIsShorterThanTheDeviceTakesToLetGoIsWhole) {
  Mapped mapped({});
  mapped.handle->lag = 1;
  mapped.feel(1.0);
  mapped.handle->clutch = true;
  mapped.tick();
  mapped.handle->clutch = false;
  bool clutched = false;
  for (int n = 0; n < 6; ++n) {
    mapped.tick();
    clutched |= mapped.servo.no_force() == ZeroForceReason::clutched;
  }
  EXPECT_TRUE(clutched);
  EXPECT_EQ(mapped.handle->on_hand, Command{});
}

TEST(Clutch, AFaultMeanwhileIsAFault) {
  Mapped mapped({});
  mapped.run(0.1);
  mapped.handle->clutch = true;
  mapped.run(0.1);
  const Vec3 stands = mapped.tool.position;
  mapped.handle->ok = false;
  mapped.run(0.02);
  EXPECT_EQ(mapped.servo.no_force(), ZeroForceReason::device_fault);
  EXPECT_EQ(mapped.servo.statistics().device.faults, 20u);
  mapped.handle->ok = true;
  mapped.run(0.1);
  mapped.handle->clutch = false;
  mapped.tick();
  EXPECT_EQ(mapped.tool.position, stands);
}

}  // namespace
}  // namespace feltwire::clutch_test
