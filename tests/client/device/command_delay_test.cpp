// Tests which command is on the hand, for devices that apply forces late. Some devices report this
// command.

#include "client/device/command_delay.hpp"

#include <gtest/gtest.h>

namespace feltwire::command_delay_test {
namespace {

Command push(double force) { return {.elastic = Vec3(0, 0, force)}; }

TEST(CommandDelay, AtOnceItIsWhatTheDeviceSays) {
  CommandDelay device(0);
  EXPECT_EQ(device.written(push(3), push(3)), push(3));
  EXPECT_EQ(device.written(push(3), push(1)), push(1));
  EXPECT_TRUE(device.certain());
  EXPECT_FALSE(device.nothing_left());
  EXPECT_EQ(device.written(push(3), {}), Command{});
  EXPECT_TRUE(device.nothing_left());
}

/// This device returns the command of its write.
TEST(CommandDelay, OfADeviceThatCannotTellItIsWhatWasGivenBefore) {
  for (int late = 1; late <= kMostLateTicks; ++late) {
    CommandDelay device(late);
    for (int n = 1; n <= 20; ++n) {
      const Command& held = device.written(push(n), push(n));
      EXPECT_EQ(held, push(std::max(0, n - late))) << late;
      EXPECT_TRUE(device.certain());
    }
    for (int n = 1; n <= late; ++n) {
      EXPECT_EQ(device.written({}, {}), push(20 - late + n)) << late;
      EXPECT_FALSE(device.nothing_left()) << late;
    }
    EXPECT_EQ(device.written({}, {}), Command{});
    EXPECT_TRUE(device.nothing_left()) << late;
  }
}

/// This device returns the command on the hand until the next write. A mapping rounds it.
TEST(CommandDelay, OfADeviceThatTellsItIsWhatItTells) {
  for (int late = 1; late <= kMostLateTicks; ++late) {
    CommandDelay device(late);
    for (int n = 1; n <= 20; ++n) {
      const Command held = push((1.0 + 1e-15) * (std::max(0, n - late) / 3));
      EXPECT_EQ(device.written(push(n / 3), held), held) << late << ' ' << n;
      EXPECT_TRUE(device.certain());
    }
  }
}

/// The device reduces one of two forces, and its report does not name this force. The worst case
/// counts for each direction of the hand's movement.
TEST(CommandDelay, WhereADeviceHoldsLessTheWorstCounts) {
  CommandDelay device(1);
  device.written(push(10), push(10));
  device.written(push(9), push(4));
  EXPECT_FALSE(device.certain());
  EXPECT_EQ(device.worst(Vec3(0, 0, 1e-3), Vec3::Zero()), push(10));
  EXPECT_EQ(device.worst(Vec3(0, 0, -1e-3), Vec3::Zero()), push(4));
  // The reduced force may now be on the hand: 9 N or 4 N.
  device.written(push(2), push(2));
  EXPECT_EQ(device.worst(Vec3(0, 0, 1e-3), Vec3::Zero()), push(9));
  EXPECT_EQ(device.worst(Vec3(0, 0, -1e-3), Vec3::Zero()), push(4));
  device.written(push(2), push(2));
  EXPECT_TRUE(device.certain());
}

}  // namespace
}  // namespace feltwire::command_delay_test
