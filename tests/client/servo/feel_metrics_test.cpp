// Compares measured oscillation and displayed stiffness with closed forms.

#include "client/servo/feel_metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "client/hands/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::feel_metrics_test {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kUp(0, 0, 1);

/// Simulates a hand on a surface. The test sets the positions of the hand, and the held force has
/// no effect.
struct Hand {
  double period;
  FeelMetrics measures{period};
  Vec3 last = Vec3::Zero();

  void at(const Vec3& position, const Vec3& elastic, const Vec3& held) {
    measures.take(position - last, elastic, held);
    last = position;
  }
  void at(const Vec3& position, const Vec3& elastic = kUp) { at(position, elastic, elastic); }
};

/// Returns the gain of the filter for a sinusoid (core/base/centred_highpass.hpp).
double share(double frequency, std::size_t window, double period) {
  const double w = static_cast<double>(window);
  return std::abs(1.0 - std::sin(kPi * frequency * w * period) /
                            (w * std::sin(kPi * frequency * period)));
}

TEST(Oscillation, OfASinusoidIsItsRmsAtAnyRate) {
  for (const double rate : {500.0, 1000.0, 4000.0, 10000.0}) {
    Hand hand{1.0 / rate};
    const std::size_t window = odd_window(kOscillationWindow, rate);
    EXPECT_NEAR(static_cast<double>(window) / rate, 0.051, 1.5 / rate);
    constexpr double kAmplitude = 30e-6;
    for (const double frequency : {40.0, 97.0}) {
      const auto before = hand.measures.squares();
      const auto samples = static_cast<int>(5.0 * rate);  // whole periods
      for (int n = 0; n < samples; ++n)
        hand.at({0.3, -0.2, 0.1 + kAmplitude * std::sin(2.0 * kPi * frequency * n / rate)});
      const auto rms = hand.measures.squares().since(before).rms();
      ASSERT_TRUE(rms);
      const double expected =
          share(frequency, window, 1.0 / rate) * kAmplitude / std::numbers::sqrt2;
      EXPECT_NEAR(*rms, expected, 0.01 * expected) << rate << " Hz, " << frequency << " Hz";
    }
  }
}

TEST(Oscillation, OfSlowAndSidewaysMovementIsNothing) {
  Hand still{0.001}, steady{0.001}, sideways{0.001}, slow{0.001};
  for (int n = 0; n < 5000; ++n) {
    const double t = 0.001 * n;
    still.at({10, 20, 30});
    steady.at({0, 0, 0.02 * t});
    sideways.at({1e-3 * std::sin(2.0 * kPi * 60.0 * t), 0, 0});
    slow.at({0, 0, 1e-3 * std::sin(2.0 * kPi * t)});
  }
  EXPECT_EQ(still.measures.oscillation(), 0.0);
  EXPECT_NEAR(*steady.measures.oscillation(), 0.0, 1e-15);
  EXPECT_EQ(sideways.measures.oscillation(), 0.0);
  EXPECT_LT(*slow.measures.oscillation(), 0.005 * 1e-3);
}

/// Rounding errors must not accumulate over a million samples far from the start of the contact.
TEST(Oscillation, KeepsItsDigits) {
  CentredHighPass filter(51);
  std::optional<double> last;
  for (int n = 0; n < 1'000'000; ++n) last = filter.push(1e3 + 1e-3 * n);
  EXPECT_NEAR(*last, 0.0, 1e-11);
}

/// A hand that bounces a hundred times a second has the largest oscillation. A hand that leaves the
/// surface has none.
TEST(Oscillation, OfAHandThatChattersIsMeasuredAndOfOneThatLeavesNot) {
  Hand chatters{0.001}, leaves{0.001};
  constexpr double kAmplitude = 1e-3;
  for (int n = 0; n < 2000; ++n) {
    const double z = kAmplitude * std::sin(2.0 * kPi * n / 10.0);
    chatters.at({0, 0, z}, z < 0.0 ? kUp : Vec3::Zero());
  }
  EXPECT_NEAR(*chatters.measures.oscillation(), kAmplitude / std::numbers::sqrt2, 0.05e-3);
  for (int n = 0; n < 200; ++n) leaves.at(Vec3::Zero());
  for (int n = 0; n < 200; ++n) leaves.at({0, 0, 5e-6 * n * n}, Vec3::Zero());
  EXPECT_EQ(leaves.measures.oscillation(), 0.0);
}

TEST(Oscillation, NeedsAWholeWindowOfContact) {
  Hand hand{0.001};
  for (int n = 0; n < 50; ++n) hand.at({0, 0, n % 2 == 0 ? 1e-3 : -1e-3});
  EXPECT_FALSE(hand.measures.oscillation());
  hand.measures.lose();
  for (int n = 0; n < 50; ++n) hand.at({0, 0, n % 2 == 0 ? 1e-3 : -1e-3});
  EXPECT_FALSE(hand.measures.oscillation());
}

/// Presses into a spring repeatedly. The device gives `share` of the force, `delay` ticks late.
FeelMetrics pressed(double stiffness, double share, int delay, double speed) {
  Hand hand{0.001};
  const auto height = [&](int n) {
    constexpr int kPeriod = 400;
    const int phase = ((n % kPeriod) + kPeriod) % kPeriod;
    const int up = phase < kPeriod / 2 ? kPeriod / 2 - phase : phase - kPeriod / 2;
    // A triangle wave, half of it above the surface
    return 1e-3 + speed * (up * 0.001) - speed * 0.1;
  };
  for (int n = 0; n < 4000; ++n) {
    const double depth = std::max(0.0, -height(n - delay));
    const Vec3 elastic(0, 0, stiffness * depth);
    hand.at({0, 0, height(n)}, elastic, share * elastic);
  }
  return hand.measures;
}

TEST(DisplayedStiffness, OfASpringIsItsOwn) {
  for (const double stiffness : {50.0, 500.0, 5000.0})
    EXPECT_NEAR(*pressed(stiffness, 1.0, 0, 0.05).displayed_stiffness(), stiffness,
                1e-6 * stiffness);
}

TEST(DisplayedStiffness, IsWhatIsGivenNotWhatIsAskedFor) {
  EXPECT_NEAR(*pressed(800.0, 0.25, 0, 0.05).displayed_stiffness(), 200.0, 1e-3);
}

/// A delay shifts the force of a steady press but keeps its slope. The slope stays correct even if
/// contact detection is late.
TEST(DisplayedStiffness, DoesNotDependOnTheDelayOfASteadyPress) {
  for (const int delay : {1, 5, 20})
    EXPECT_NEAR(*pressed(500.0, 1.0, delay, 0.05).displayed_stiffness(), 500.0, 1e-3) << delay;
}

/// A hand slides around a ball at constant depth. The measure must not count this as a press.
TEST(DisplayedStiffness, SlidingIsNoPress) {
  Hand hand{0.001};
  for (int n = 0; n < 3000; ++n) {
    const double angle = 0.002 * n;
    const Vec3 normal(std::sin(angle), 0, std::cos(angle));
    hand.at(0.04 * normal, normal, normal);
  }
  EXPECT_FALSE(hand.measures.displayed_stiffness());
}

/// Encoder steps of 30 um may change the measured slope by a few percent only.
TEST(DisplayedStiffness, StandsEncoderQuanta) {
  Hand hand{0.001};
  constexpr double kQuantum = 30e-6;
  for (int n = 0; n < 4000; ++n) {
    const double z = 1e-3 * std::cos(2.0 * kPi * n / 1000.0);
    const double read = kQuantum * std::round(z / kQuantum);
    hand.at({0, 0, read}, {0, 0, 1000.0 * std::max(0.0, -read)});
  }
  EXPECT_NEAR(*hand.measures.displayed_stiffness(), 1000.0, 30.0);
}

/// In a complete servo, a simulated hand presses a spring of 400 N/m without bound and delay.
TEST(DisplayedStiffness, OfAServoOnASpring) {
  SimulatedDevice device({.spec = builtin_device("simulated"), .hand = {}, .task = {}});
  Servo servo(device.spec(), testing::servo::parameters("none"));
  Nanoseconds now{0};
  for (int n = 0; n < 4000; ++n) {
    now += std::chrono::milliseconds(1);
    const DeviceReading reading = device.read(now);
    servo.hold(device.write(servo.render(reading, now)));
    servo.take(testing::servo::reply(servo.sample().index,
                                     testing::servo::elastic(
                                         0, 0, 400.0 * std::max(0.0, -reading.pose.position.z()))),
               now);
  }
  ASSERT_TRUE(servo.measures().displayed_stiffness());
  EXPECT_NEAR(*servo.measures().displayed_stiffness(), 400.0, 20.0);
  ASSERT_TRUE(servo.measures().oscillation());
  EXPECT_LT(*servo.measures().oscillation(), 100e-6);
}

/// A servo with a simulated hand that presses a spring of 400 N/m.
struct Pressing {
  explicit Pressing(const ServoOptions& options = {})
      : device({.spec = builtin_device("simulated"), .hand = {}, .task = {}}),
        servo(device.spec(), testing::servo::parameters("none"), options) {}
  void run(double time, bool answered = true) {
    for (double t = 0.0; t < time; t += 1e-3) {
      now += std::chrono::milliseconds(1);
      const DeviceReading reading = device.read(now);
      servo.hold(device.write(servo.render(reading, now)));
      if (!answered) continue;
      const double depth = std::max(0.0, -reading.pose.position.z());
      servo.take(
          testing::servo::reply(servo.sample().index, testing::servo::elastic(0, 0, 400.0 * depth)),
          now);
    }
  }
  void expect_measures_of_the_spring() const {
    ASSERT_TRUE(servo.measures().displayed_stiffness());
    EXPECT_NEAR(*servo.measures().displayed_stiffness(), 400.0, 20.0);
    ASSERT_TRUE(servo.measures().oscillation());
    EXPECT_LT(*servo.measures().oscillation(), 100e-6);
  }
  SimulatedDevice device;
  Servo servo;
  Nanoseconds now{0};
};

/// At the end the force fades and the hand sinks. The measure must not count this as a press.
TEST(DisplayedStiffness, TheEndOfARunDoesNotCount) {
  Pressing hand;
  hand.run(2.5);
  hand.expect_measures_of_the_spring();
  const auto squares = hand.servo.measures().squares();
  const auto directions = hand.servo.statistics().direction_error.count();
  hand.servo.release();
  hand.run(0.2);
  EXPECT_EQ(hand.servo.statistics().direction_error.count(), directions);
  EXPECT_EQ(hand.servo.measures().squares().count, squares.count);
  hand.expect_measures_of_the_spring();
}

TEST(DisplayedStiffness, AFadeAndWhatIsWithheldAfterItDoNotCount) {
  for (const double outage : {0.07, 0.095, 0.3}) {
    for (const bool waits : {false, true}) {
      ServoOptions options;
      if (waits) options.safety.force.small = 0.05;
      options.safety.ramp_up = waits ? 0.0 : 0.05;
      Pressing hand(options);
      hand.run(2.5);
      for (int n = 0; n < 4; ++n) {
        hand.run(outage, false);
        hand.run(0.4);
      }
      hand.expect_measures_of_the_spring();
    }
  }
}

}  // namespace
}  // namespace feltwire::feel_metrics_test
