// Tests how a command fades with its age, and how a force ends.

#include "client/servo/force_fade.hpp"

#include <gtest/gtest.h>

namespace feltwire::force_fade_test {
namespace {

constexpr double kHold = 0.1, kTick = 1e-3;  // [s]

Nanoseconds at(double time) { return from_seconds(time); }

/// The command is complete until half the hold time, then falls linearly to zero at the hold time.
TEST(ForceFade, FollowsTheAgeOfTheCommand) {
  for (int n = 0; n <= 120; ++n) {
    ForceFade fade;
    const double age = n * kTick;
    const double line = std::clamp(2.0 - 20.0 * age, 0.0, 1.0);
    EXPECT_NEAR(fade.step(at(1.0), age, kTick, kHold), line, 1e-12) << age;
    EXPECT_EQ(fade.silent(), age >= kHold) << age;
  }
}

TEST(ForceFade, AnEndTakesHalfTheHoldTimeHoweverFreshTheCommand) {
  ForceFade fade;
  fade.begin(at(1.0));
  fade.begin(at(1.02));  // The force is already fading.
  for (int n = 0; n <= 60; ++n) {
    const double share = fade.step(at(1.0 + n * kTick), 0.0, kTick, kHold);
    EXPECT_NEAR(share, std::max(0.0, 1.0 - 20.0 * n * kTick), 1e-6) << n;
    EXPECT_FALSE(fade.silent());
  }
  EXPECT_TRUE(fade.ending());
}

/// The force rises at the rate at which it fell.
TEST(ForceFade, ComesBackNoFasterThanItWent) {
  ForceFade fade;
  fade.begin(at(1.0));
  EXPECT_EQ(fade.step(at(1.05), 0.0, kTick, kHold), 0.0);
  fade.end();
  for (int n = 1; n <= 60; ++n)
    EXPECT_NEAR(fade.step(at(1.05 + n * kTick), 0.0, kTick, kHold), std::min(1.0, 20.0 * n * kTick),
                1e-9)
        << n;
}

TEST(ForceFade, AClockThatIsSetBackTakesTheBeginningWithIt) {
  ForceFade fade;
  fade.begin(at(100.0));
  fade.move_times(at(-90.0));
  EXPECT_NEAR(fade.step(at(10.025), 0.0, kTick, kHold), 0.5, 1e-6);
}

/// The device's largest force clamps a larger command before the fade. The force therefore starts
/// to fall at once.
TEST(ForceFade, FadesFromTheForceOfTheDevice) {
  const Command far{.elastic = Vec3(0, 0, 100), .torque = Vec3(10, 0, 0)};
  const Command half = faded(far, 0.5, 8.0, 0.4);
  EXPECT_NEAR(half.force().z(), 4.0, 1e-12);
  EXPECT_NEAR(half.torque.x(), 0.2, 1e-12);
  EXPECT_EQ(faded(far, 1.0, 8.0, 0.4), far);
  const Command small{.frictional = Vec3(2, 0, 0)};
  EXPECT_NEAR(faded(small, 0.25, 8.0, 0.4).force().x(), 0.5, 1e-12);
}

}  // namespace
}  // namespace feltwire::force_fade_test
