// A hand rests between two encoder readings. Tests when the method detects the rest, and where it
// then evaluates the scene. A stiff wall must not extract energy from such a hand.

#include "core/bounding/quantized_rest_position.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/bounding/midpoint.hpp"

namespace feltwire::quantized_rest_position_test {
namespace {

constexpr double kPeriod = 1e-3;   // [s]
constexpr double kQuantum = 2e-5;  // [m]
constexpr int kUntilRest = 50;     // [samples] QuantizedRestPosition::kRest
constexpr double kAhead = 0.5;     // [samples]

/// Alternates between two readings, one sample each. Returns the last offset.
double dither(QuantizedRestPosition& place, int samples, double first = kQuantum) {
  double offset = 0.0, by = first;
  for (int n = 0; n < samples; ++n, by = -by) {
    offset = place.offset(Vec3(0, 0, by), kAhead).z();
    place.moved(Vec3(0, 0, by), kPeriod);
  }
  return offset;
}

TEST(QuantizedRestPosition, AMovingHandIsAskedForHalfASampleAhead) {
  QuantizedRestPosition place(kQuantum);
  for (int n = 0; n < 200; ++n) {
    const Vec3 dx(3e-5, -2e-5, 4e-5);
    EXPECT_EQ(place.offset(dx, kAhead), Vec3(0.5 * dx));
    place.moved(dx, kPeriod);
  }
}

TEST(QuantizedRestPosition, AHandThatDithersBetweenTwoReadingsIsAskedForBetweenThem) {
  QuantizedRestPosition place(kQuantum);
  dither(place, kUntilRest);
  // s is the position between the two readings, as a fraction of the quantum above the lower
  // reading. A step up changes s to s + kStep (1 - s). A step down changes s to (1 - kStep) s.
  const double settled = dither(place, 200);  // after a step down
  const double s = (1.0 - QuantizedRestPosition::kStep) / (2.0 - QuantizedRestPosition::kStep);
  EXPECT_NEAR(settled, s * kQuantum, 1e-12);
}

TEST(QuantizedRestPosition, WhereItStandsStillThePlaceStands) {
  QuantizedRestPosition place(kQuantum);
  dither(place, kUntilRest + 30);
  const double offset = place.offset(Vec3::Zero(), kAhead).z();
  EXPECT_NE(offset, 0.0);
  for (int n = 0; n < 10'000; ++n) {
    EXPECT_EQ(place.offset(Vec3::Zero(), kAhead).z(), offset);
    place.moved(Vec3::Zero(), kPeriod);
  }
}

TEST(QuantizedRestPosition, AThirdReadingEndsTheRest) {
  QuantizedRestPosition place(kQuantum);
  dither(place, 2 * kUntilRest);  // The last step was down.
  const Vec3 on(0, 0, -kQuantum);
  EXPECT_EQ(place.offset(on, kAhead), Vec3(0.5 * on));
  place.moved(on, kPeriod);
  EXPECT_EQ(dither(place, 2), -0.5 * kQuantum) << "a rest takes its time again";
}

TEST(QuantizedRestPosition, ThePlaceIsNeverFartherThanAQuantumFromTheReading) {
  QuantizedRestPosition place(kQuantum);
  unsigned state = 1;
  for (int n = 0; n < 100'000; ++n) {
    state = state * 1664525u + 1013904223u;
    const double by = (state >> 16) % 40 == 0 ? (state & 0x8000u ? kQuantum : -kQuantum) : 0.0;
    EXPECT_LE(std::abs(place.offset(Vec3(by, 0, 0), kAhead).x()), kQuantum * (1.0 + 1e-9));
    place.moved(Vec3(by, 0, 0), kPeriod);
  }
}

TEST(QuantizedRestPosition, WithoutAQuantumItIsTheMidpoint) {
  QuantizedRestPosition place(0.0);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 dx(0, 0, 1e-7 * (n % 3 - 1));
    EXPECT_EQ(place.offset(dx, kAhead), Vec3(0.5 * dx));
    place.moved(dx, kPeriod);
  }
}

/// Returns the energy [J] that a wall of stiffness k gives to a hand that alternates by one encoder
/// step.
double given_by_wall(bool rests, double stiffness) {
  Midpoint<double> midpoint(rests ? kQuantum : 0.0, kPeriod);
  double reading = -5.0 * kQuantum, held = 0.0, given = 0.0;
  for (int n = 0; n < 1200; ++n) {
    const double by = n % 4 != 0 ? 0.0 : n % 8 == 0 ? kQuantum : -kQuantum;
    if (n >= 200) given += held * by;
    reading += by;
    const Vec3 dx(0, 0, by);
    const double asked = reading + midpoint.probe(dx, Vec3::Zero()).offset.z();
    const BoundingStep step{.displacement = dx,
                            .hold_time = kPeriod,
                            .command = {.elastic = Vec3(0, 0, -stiffness * asked)}};
    held = midpoint.step(step).elastic.z();
  }
  return given;
}

TEST(QuantizedRestPosition, ADitherTakesAShareOfWhatItTookFromTheStaircase) {
  constexpr double kStiffness = 4e4;
  const double cycle = kStiffness * kQuantum * kQuantum;
  EXPECT_NEAR(given_by_wall(false, kStiffness), 125.0 * cycle, 1e-9);
  EXPECT_NEAR(given_by_wall(true, kStiffness),
              125.0 * cycle * QuantizedRestPosition::kStep / (2.0 - QuantizedRestPosition::kStep),
              1e-9);
}

}  // namespace
}  // namespace feltwire::quantized_rest_position_test
