#include "core/safety/safety.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/core/contact_frame_fixture.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::safety_test {
namespace {

using namespace test;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Returns a sample of a port without a bound. The stage gets the complete command.
SafetyStep step(const Command& command, const Vec3& displacement = Vec3::Zero()) {
  return {
      .commanded = command, .bounded = command, .displacement = displacement, .hold_time = kPeriod};
}
Command push(double newtons, double newton_metres = 0.0) {
  return {.elastic = newtons * Vec3(0, 0.48, 0.6),
          .frictional = newtons * Vec3(0, 0.12, 0.2),  // The sum is newtons * (0, 0.6, 0.8).
          .torque = Vec3(newton_metres, 0, 0)};
}
double force(const Safeguarded& s) { return s.rendered.force().norm(); }

TEST(Safety, WithoutLimitsEverythingPasses) {
  Random random(1);
  SafetyStage stage;
  for (int n = 0; n < 1000; ++n) {
    const SafetyStep s = step(random_command(random), random.vector(-8, 0));
    const Safeguarded out = stage.apply(s);
    EXPECT_EQ(out.rendered.elastic, s.bounded.elastic);
    EXPECT_EQ(out.rendered.frictional, s.bounded.frictional);
    EXPECT_EQ(out.rendered.torque, s.bounded.torque);
    EXPECT_FALSE(out.limited || out.slewed || out.too_fast || out.ramped || out.waiting ||
                 out.refused);
  }
}

TEST(Safety, TheMaximumHoldsForForceAndTorqueApart) {
  SafetyStage stage({.force = {.max = 2.0}, .torque = {.max = 0.1}});
  Safeguarded out = stage.apply(step(push(5.0, 0.05)));
  EXPECT_TRUE(out.limited);
  // The stage scales each part by 2 / 5.
  EXPECT_TRUE(out.rendered.elastic.isApprox(0.4 * push(5.0).elastic));
  EXPECT_TRUE(out.rendered.frictional.isApprox(0.4 * push(5.0).frictional));
  EXPECT_EQ(out.rendered.torque.x(), 0.05);
  out = stage.apply(step(push(1.5, 0.4)));
  EXPECT_TRUE(out.limited);
  EXPECT_EQ(out.rendered.force(), push(1.5).force());
  EXPECT_NEAR(out.rendered.torque.x(), 0.1, 1e-15);
  EXPECT_FALSE(stage.apply(step(push(2.0, 0.1))).limited);
}

TEST(Safety, SlewLimitsTheRiseOnlyAndFromWhatWasHeld) {
  // 0.5 N and 0.02 N m per sample
  SafetyStage stage({.force = {.slew = 500.0}, .torque = {.slew = 20.0}});
  for (const int n : {1, 2, 3}) {
    const Safeguarded out = stage.apply(step(push(5.0, 0.1)));
    EXPECT_TRUE(out.slewed);
    EXPECT_NEAR(force(out), 0.5 * n, 1e-12);
    EXPECT_NEAR(out.rendered.torque.x(), 0.02 * n, 1e-12);
  }
  stage.set_held(push(0.2, 0.0));  // The device held less force than commanded.
  EXPECT_NEAR(force(stage.apply(step(push(5.0)))), 0.7, 1e-12);
  stage.set_held({.elastic = Vec3(kNan, 0, 0)});  // The stage ignores this value.
  EXPECT_NEAR(force(stage.apply(step(push(5.0)))), 1.2, 1e-12);
  const Safeguarded fallen = stage.apply(step(push(0.1)));
  EXPECT_EQ(fallen.rendered.force(), push(0.1).force());
  EXPECT_FALSE(fallen.slewed);
}

TEST(Safety, TimeThatDoesNotPassLetsNothingRise) {
  for (const double time : {0.0, -1.0}) {
    SafetyStage stage({.force = {.slew = 500.0}, .ramp_up = 0.1});
    SafetyStep s = step(push(5.0));
    s.hold_time = time;
    for (int n = 0; n < 10; ++n) EXPECT_EQ(force(stage.apply(s)), 0.0) << time;
  }
}

TEST(Safety, AboveTheSpeedLimitTheShareFallsLinearlyToNothingAtTwice) {
  for (const double speed : {0.2, 0.99, 1.2, 1.5, 1.9, 2.0, 7.0}) {
    SafetyStage stage({.force = {.speed = 1.0}, .torque = {.speed = 10.0}});
    SafetyStep s = step(push(3.0, 0.2), Vec3(0, 0, -speed * kPeriod));
    s.rotation = Vec3(10.0 * speed * kPeriod, 0, 0);
    Safeguarded out;
    for (int n = 0; n < 1000; ++n) out = stage.apply(s);  // The low-pass filter settles.
    const double share = std::clamp(2.0 - speed, 0.0, 1.0);
    EXPECT_NEAR(force(out), 3.0 * share, 1e-9) << speed;
    EXPECT_NEAR(out.rendered.torque.x(), 0.2 * share, 1e-9) << speed;
    EXPECT_EQ(out.too_fast, speed > 1.0) << speed;
  }
  // Each channel's own movement limits its output.
  SafetyStage stage({.force = {.speed = 1.0}, .torque = {.speed = 10.0}});
  Safeguarded out;
  for (int n = 0; n < 1000; ++n) out = stage.apply(step(push(3.0, 0.2), Vec3(0.005, 0, 0)));
  EXPECT_EQ(force(out), 0.0);
  EXPECT_EQ(out.rendered.torque.x(), 0.2);
}

/// A hand moves steadily above the limit, with encoders of 55 um. Raw differences alternate between
/// two speeds 55 mm/s apart, or 5.5 % of the force. The rendered force must vary less.
TEST(Safety, NearTheSpeedLimitEncoderQuantaDoNotChatter) {
  constexpr double kQuantum = 55e-6;
  for (const double speed : {0.98, 1.0, 1.02, 1.3, 1.7}) {
    SafetyStage stage({.force = {.speed = 1.0}});
    double last_position = 0.0, last_force = 0.0, jump = 0.0;
    for (int n = 1; n <= 3000; ++n) {
      const double position = std::round(speed * n * kPeriod / kQuantum) * kQuantum;
      const double now = force(stage.apply(step(push(1.0), Vec3(position - last_position, 0, 0))));
      if (n > 100) jump = std::max(jump, std::abs(now - last_force));
      last_position = position;
      last_force = now;
    }
    EXPECT_LT(jump, 0.02) << speed;
  }
}

TEST(Safety, TheFirstContactGrowsLinearly) {
  SafetyStage stage({.ramp_up = 0.1});
  for (int n = 0; n < 500; ++n) stage.apply(step({}));  // Free space is no contact.
  for (int n = 0; n < 150; ++n) {
    const Safeguarded out = stage.apply(step(push(4.0, 0.2)));
    const double share = std::min(1.0, n * kPeriod / 0.1);
    EXPECT_NEAR(force(out), 4.0 * share, 1e-9) << n;
    EXPECT_NEAR(out.rendered.torque.x(), 0.2 * share, 1e-9) << n;
    if (n == 100) continue;  // Rounding decides this sample.
    EXPECT_EQ(out.ramped, n < 100) << n;
  }
  stage.apply(step({}));
  const Safeguarded again = stage.apply(step(push(4.0)));
  EXPECT_EQ(again.rendered.force(), push(4.0).force());  // Only the first contact has a ramp.
  EXPECT_FALSE(again.ramped);
}

/// A hand presses in at once and rests. The bound's output depends on the held force. If the stage
/// gave only a fraction of this output, the force would vanish after a few samples.
TEST(Safety, BehindABoundTheRampAndTheSpeedKeepWhatTheyLetThrough) {
  for (const bool ramp : {true, false}) {
    SafetyLimits limits;
    if (ramp)
      limits.ramp_up = 0.1;
    else
      limits.force.speed = 0.5;
    Bounding bounding(contact_frame());
    SafetyStage stage(limits);
    const Command spring{.elastic = Vec3(0, 0, 8.0)};
    double held = 0.0, before_rest = 0.0;
    for (int n = 0; n < 200; ++n) {
      const Vec3 displacement(0, 0, n >= 1 && n <= 10 ? -0.8e-3 : 0.0);  // 0.8 m/s, 8 mm
      const Command let_through =
          bounding.step({displacement, Vec3::Zero(), kPeriod, spring}).rendered;
      const Safeguarded out = stage.apply({.commanded = spring,
                                           .bounded = let_through,
                                           .displacement = displacement,
                                           .hold_time = kPeriod});
      bounding.set_held(out.rendered);
      held = force(out);
      if (n == 10) before_rest = held;
    }
    EXPECT_GT(before_rest, 0.5) << ramp;
    EXPECT_LT(before_rest, 8.0) << ramp;
    EXPECT_NEAR(held, before_rest, 1e-9) << ramp;
  }
}

TEST(Safety, NothingIsGivenUntilTheScenesOwnCommandHasBeenSmall) {
  SafetyStage stage({.force = {.small = 0.1}, .torque = {.small = 0.01}, .ramp_up = 0.1});
  for (int n = 0; n < 200; ++n) {
    const Safeguarded out = stage.apply(step(push(4.0, 0.05)));
    EXPECT_TRUE(out.waiting);
    EXPECT_EQ(force(out) + out.rendered.torque.norm(), 0.0);
  }
  EXPECT_TRUE(stage.apply(step(push(0.05, 0.05))).waiting);  // Force and torque must both be small.
  // Inside an object, a bound gives no force at first. This zero force is not the scene's own
  // command.
  SafetyStep changed = step({});
  changed.original = false;
  EXPECT_FALSE(stage.apply(changed).waiting);  // A zero force needs no wait.
  EXPECT_TRUE(stage.apply(step(push(0.05, 0.05))).waiting);
  // A small command must end the wait permanently. The ramp must begin only now.
  EXPECT_FALSE(stage.apply(step(push(0.1, 0.01))).waiting);
  const Safeguarded out = stage.apply(step(push(4.0)));
  EXPECT_FALSE(out.waiting);
  // The ramp lasts 0.1 s. One period of the ramp has passed.
  EXPECT_NEAR(force(out), 0.01 * 4.0, 1e-12);
}

/// A waiting stage and its force channel.
struct Waiting {
  explicit Waiting(bool reduces = true) : stage({.force = {.small = 0.05}}, reduces) {}
  double at(double commanded, double moved = 0.0) {
    return force(stage.apply(step(push(commanded), Vec3(0, 0, moved))));
  }
  SafetyStage stage;
};

TEST(Safety, WhoBeginsInsideFeelsAtOnceWhatHeAdds) {
  Waiting w;
  EXPECT_EQ(w.at(4.0), 0.0);
  EXPECT_NEAR(w.at(4.5), 0.5, 1e-12);  // The hand moves deeper.
  EXPECT_EQ(w.at(4.0), 0.0);
  EXPECT_EQ(w.at(3.0), 0.0);  // The depth decreases and sets the new reference.
  EXPECT_NEAR(w.at(4.0), 1.0, 1e-12);
  EXPECT_LE(w.at(0.05), 0.05);  // The hand moves out, and the wait ends.
  EXPECT_EQ(w.at(4.0), 4.0);
}

/// A field may be large everywhere. The force must fade in without a jump as the hand moves, but
/// not while the hand rests.
TEST(Safety, AFieldThatIsNeverSmallIsLetInAsTheHandMoves) {
  Waiting w;
  for (int n = 0; n < 10'000; ++n) ASSERT_EQ(w.at(2.0), 0.0);
  constexpr double kStep = 1e-4;  // [m] 0.1 m/s at 1 kHz
  double before = 0.0, way = 0.0;
  for (; before < 2.0 && way < 1.0; way += kStep) {
    const double given = w.at(2.0, kStep);
    ASSERT_GE(given, before);
    // The reference force ends at a small value. The last step may rise by the threshold plus the
    // part from this movement.
    ASSERT_LE(given - before, 0.05 * (1.0 + kStep / SafetyLimits::kFloorWay) + 1e-12);
    before = given;
  }
  EXPECT_EQ(before, 2.0);
  // [m] tolerance for the delay of the filter
  EXPECT_NEAR(way, (2.0 - 0.05) / 0.05 * SafetyLimits::kFloorWay, 2e-3);
}

/// A free mass connects 5 mm deep in a wall, with an initial speed of 2 mm/s outwards.
TEST(Safety, NobodyIsThrownOutOfAWallThatHeBeganIn) {
  for (const bool waits : {true, false}) {
    SafetyStage stage({.force = {.small = waits ? 0.05 : kInfinity}});
    constexpr double kStiffness = 900.0, kMass = 0.1, kFriction = 0.5;
    double x = -5e-3, v = 2e-3, fastest = 0.0;
    for (int n = 0; n < 5000; ++n) {
      const Vec3 moved(0, 0, kPeriod * v);
      x += kPeriod * v;
      const double given = force(stage.apply(step(push(kStiffness * std::max(0.0, -x)), moved)));
      v += kPeriod / kMass * (given - kFriction * v);
      fastest = std::max(fastest, v);
    }
    if (waits)
      EXPECT_LE(fastest, 2e-3);
    else
      EXPECT_GT(fastest, 0.1);
  }
}

// Some methods also bound the force from below. Such a method must get no force until the wait
// ends, and the complete force afterwards.
TEST(Safety, BehindABoundThatAdmitsNoReductionAWaitGivesNothing) {
  Waiting w(false);
  for (const double commanded : {4.0, 4.5, 0.06, 3.0}) EXPECT_EQ(w.at(commanded, 1e-3), 0.0);
  w.at(0.05);
  EXPECT_EQ(w.at(4.0), 4.0);
}

TEST(Safety, WhatIsNotFiniteGivesNothing) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    const Vec3 broken(0, bad, 0);
    SafetyStep steps[6];
    for (SafetyStep& s : steps) s = step(push(2.0, 0.1), Vec3(1e-3, 0, 0));
    steps[0].displacement = broken;
    steps[1].rotation = broken;
    steps[2].hold_time = bad;
    steps[3].bounded.torque = broken;
    steps[4].commanded.elastic = broken;
    steps[5].bounded.frictional = broken;
    for (const SafetyStep& s : steps) {
      SafetyStage stage({.force = {.slew = 1e6}});
      stage.apply(step(push(2.0, 0.1)));
      const Safeguarded out = stage.apply(s);
      EXPECT_TRUE(out.refused);
      EXPECT_EQ(out.rendered.force(), Vec3::Zero());
      EXPECT_EQ(out.rendered.torque, Vec3::Zero());
      // The bad sample must not affect the next samples.
      EXPECT_EQ(stage.apply(step(push(2.0, 0.1))).rendered.force(), push(2.0).force());
    }
  }
  // Finite numbers may give an infinite velocity or sum.
  SafetyStage stage;
  SafetyStep s = step(push(2.0), Vec3(1e300, 0, 0));
  s.hold_time = 1e-300;
  EXPECT_TRUE(stage.apply(s).refused);
  s = step({.elastic = Vec3(1.5e308, 0, 0), .frictional = Vec3(1.5e308, 0, 0)});
  EXPECT_TRUE(stage.apply(s).refused);
}

TEST(Safety, LimitsThatCannotBeAreRefusedByName) {
  const auto error = [](const SafetyLimits& limits) -> std::string {
    try {
      SafetyStage stage(limits);
    } catch (const std::invalid_argument& refused) {
      return refused.what();
    }
    return "";
  };
  for (const double bad : {0.0, -1.0, kNan}) {
    EXPECT_NE(error({.force = {.max = bad}}).find("force.max = "), std::string::npos);
    EXPECT_NE(error({.force = {.slew = bad}}).find("force.slew = "), std::string::npos);
    EXPECT_NE(error({.torque = {.speed = bad}}).find("torque.speed = "), std::string::npos);
    if (bad != 0.0) {
      EXPECT_NE(error({.torque = {.small = bad}}).find("torque.small = "), std::string::npos);
      EXPECT_NE(error({.ramp_up = bad}).find("ramp_up = "), std::string::npos);
    }
  }
  EXPECT_NE(error({.ramp_up = kInfinity}).find("ramp_up = inf"), std::string::npos);
  EXPECT_EQ(error({.force = {.small = 0.0}, .ramp_up = 10.0}), "");
}

TEST(Safety, TenThousandStepsAllocateNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  Random random(5);
  SafetyStage stage({.force = {.max = 5.0, .slew = 1e3, .speed = 1.0, .small = 1.0},
                     .torque = {.max = 0.1, .slew = 10.0, .speed = 1.0, .small = 1.0},
                     .ramp_up = 1.0});
  const std::size_t before = test::allocations();
  int given = 0;
  for (int n = 0; n < 10'000; ++n) {
    const Safeguarded out = stage.apply(step(random_command(random), random.vector(-6, -3)));
    stage.set_held(out.rendered);
    given += out.rendered.force().norm() > 0.0;
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(given, 1000);
}

}  // namespace
}  // namespace feltwire::safety_test
