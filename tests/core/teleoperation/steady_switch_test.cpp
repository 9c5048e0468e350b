// Tests an enabling switch with contact bounce.

#include "core/teleoperation/steady_switch.hpp"

#include <gtest/gtest.h>

namespace feltwire::steady_switch_test {
namespace {

using std::chrono::milliseconds;

/// Presses and releases for these times [ms]. Returns how often the switch becomes pressed.
int presses(SteadySwitch& steady, Nanoseconds& now, int held, int released, int times) {
  int counted = 0;
  for (int n = 0; n < times; ++n) {
    bool before = false;
    for (int t = 0; t < held; ++t, now += milliseconds(1)) {
      const bool counts = steady.step(true, now);
      EXPECT_TRUE(counts || !before) << "while it is held it goes on to count";
      counted += counts && !before ? 1 : 0;
      before = counts;
    }
    for (int t = 0; t < released; ++t, now += milliseconds(1))
      EXPECT_FALSE(steady.step(false, now)) << "a release counts at once";
  }
  return counted;
}

TEST(SteadySwitch, AHandsPressesCountAtOnce) {
  SteadySwitch steady;
  Nanoseconds now = std::chrono::hours(1);
  EXPECT_EQ(presses(steady, now, 1, 300, 20), 20);
  EXPECT_EQ(presses(steady, now, 100, 200, 20), 20);
  now += std::chrono::seconds(2);
  EXPECT_EQ(presses(steady, now, 1, 1, 2), 2) << "twice in a row";
}

TEST(SteadySwitch, AFlickerStaysReleased) {
  for (const auto& [held, released] : {std::pair{1, 1}, {5, 1}, {1, 20}, {100, 3}, {120, 80}}) {
    SteadySwitch steady;
    Nanoseconds now{0};
    EXPECT_EQ(presses(steady, now, held, released, 50), int{SteadySwitch::kPresses}) << held;
    // A steady press must count.
    bool counts = false;
    for (int t = 0; t <= 500; ++t, now += milliseconds(1)) counts = steady.step(true, now);
    EXPECT_TRUE(counts) << held;
    // After a rest the switch must count at once.
    now += std::chrono::seconds(2);
    EXPECT_FALSE(steady.step(false, now));
    EXPECT_TRUE(steady.step(true, now + milliseconds(1)));
  }
}

}  // namespace
}  // namespace feltwire::steady_switch_test
