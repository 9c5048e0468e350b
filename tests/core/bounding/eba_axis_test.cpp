// Tests the conditions of the paper on one axis. docs/bounding.md names the paper.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/bounding/per_axis.hpp"
#include "tests/core/support.hpp"

namespace feltwire::eba_axis_test {
namespace {

using test::Random;

double square(double x) { return x * x; }

struct AxisCase {
  double command, dx, held;
  EbaConstants c;
};

AxisCase random_case(Random& random) {
  AxisCase a{random.decades(-6, 6), random.decades(-9, 3), random.decades(-6, 6), {}};
  a.c.c1 = std::abs(random.decades(-3, 6));
  a.c.c2 = a.c.c1 * (random.chance(0.3) ? 1.0 : random.uniform(0.0, 1.0));
  if (random.chance(0.05)) a.dx = 0.0;
  if (random.chance(0.05)) a.held = 0.0;
  return a;
}

TEST(EbaAxis, BothLawsHoldOverTwelveDecades) {
  Random random(11);
  for (int n = 0; n < 500000; ++n) {
    const AxisCase a = random_case(random);
    const double f = eba_axis(a.command, a.dx, a.held, a.c);
    // F(n) dx >= (F(n)^2 - F(n-1)^2) / (2 c2), times 2 c2.
    const double inflow = 2.0 * a.c.c2 * a.dx * f;
    EXPECT_GE(inflow - (square(f) - square(a.held)),
              -1e-14 * (std::abs(inflow) + square(f) + square(a.held)));
    // (F(n) - F(n-1)) dx <= c1 dx^2
    EXPECT_LE((f - a.held) * a.dx - a.c.c1 * square(a.dx),
              1e-14 * ((std::abs(f) + std::abs(a.held)) * std::abs(a.dx) + a.c.c1 * square(a.dx)));
  }
}

// At the limit of the inequalities, the method must not reduce the force further.
TEST(EbaAxis, NothingThatTheLawsAllowIsTaken) {
  Random random(12);
  int inside = 0, outside = 0;
  for (int n = 0; n < 500000; ++n) {
    AxisCase a = random_case(random);
    if (random.chance(0.5))
      a.command = random.uniform(-2.0, 2.0) * (std::abs(a.held) + 2.0 * a.c.c1 * std::abs(a.dx));
    const double inflow = 2.0 * a.c.c2 * a.dx * a.command;
    const double energy = inflow + square(a.held) - square(a.command);
    const double hold = a.c.c1 * square(a.dx) - (a.command - a.held) * a.dx;
    const double energy_scale = std::abs(inflow) + square(a.held) + square(a.command);
    const double hold_scale =
        a.c.c1 * square(a.dx) + (std::abs(a.command) + std::abs(a.held)) * std::abs(a.dx);
    const double f = eba_axis(a.command, a.dx, a.held, a.c);
    if (energy > 1e-12 * energy_scale && (hold > 1e-12 * hold_scale || a.dx == 0.0)) {
      EXPECT_EQ(f, a.command);
      ++inside;
    } else if (energy < -1e-12 * energy_scale || hold < -1e-12 * hold_scale) {
      EXPECT_NE(f, a.command);
      ++outside;
    }
  }
  EXPECT_GT(inside, 10000);
  EXPECT_GT(outside, 10000);
}

/// beta and gamma as the paper prints them, with the given radicand.
double printed_form(const AxisCase& a, double under_the_root) {
  const double ratio = a.held / a.dx;
  const double root = std::sqrt(under_the_root + square(ratio));
  const double gamma_max = a.c.c2 - ratio + root, gamma_min = a.c.c2 - ratio - root;
  const double beta = (a.command - a.held) / a.dx;
  const double beta_max = std::min(a.c.c1, gamma_max), beta_min = gamma_min;
  return a.held + std::max(beta_min, std::min(beta_max, beta)) * a.dx;
}

TEST(EbaAxis, EqualsThePrintedFormWhereThatCanBeComputed) {
  Random random(13);
  for (int n = 0; n < 500000; ++n) {
    AxisCase a = random_case(random);
    if (a.dx == 0.0) continue;
    const double scale = std::abs(a.held) + 2.0 * a.c.c1 * std::abs(a.dx);
    if (random.chance(0.5)) a.command = random.uniform(-2.0, 2.0) * scale;
    EXPECT_NEAR(eba_axis(a.command, a.dx, a.held, a.c), printed_form(a, square(a.c.c2)),
                1e-13 * (scale + std::abs(a.command)));
  }
}

// Fact 1: the paper prints sqrt(c2 + (F/dx)^2). This term adds N/m to (N/m)^2 and breaks the energy
// condition.
TEST(EbaAxis, ThePrintedRadicalBreaksTheEnergyLawTheSquaredOneNever) {
  Random random(14);
  int printed_breaks = 0;
  for (int n = 0; n < 100000; ++n) {
    AxisCase a = random_case(random);
    if (a.dx == 0.0) continue;
    const double scale = std::abs(a.held) + a.c.c2 * std::abs(a.dx);
    a.command = random.uniform(-3.0, 3.0) * scale;
    const auto broken = [&](double f) {
      const double inflow = 2.0 * a.c.c2 * a.dx * f;
      return square(f) - square(a.held) - inflow > 1e-9 * (square(scale) + square(f));
    };
    EXPECT_FALSE(broken(printed_form(a, square(a.c.c2))));
    printed_breaks += broken(printed_form(a, a.c.c2));
  }
  EXPECT_GT(printed_breaks, 100);
  // Example: c2 = 0.25 N/m, dx = 1 m, no held force. The condition allows 0 .. 0.5 N, but the
  // printed radical allows up to 0.75 N.
  const AxisCase a{9.0, 1.0, 0.0, {.c1 = 9.0, .c2 = 0.25}};
  EXPECT_DOUBLE_EQ(eba_axis(a.command, a.dx, a.held, a.c), 0.5);
  EXPECT_DOUBLE_EQ(printed_form(a, a.c.c2), 0.75);
}

// Fact 2: with c2 > c1, some inputs have no valid force. With c2 <= c1, each input has a valid
// force.
TEST(EbaAxis, TheLawsContradictEachOtherOnlyWhenC2IsAboveC1) {
  const EbaConstants above{.c1 = 1.0, .c2 = 2.0};
  const double held = -100.0, dx = 1.0;
  const double gamma_min = above.c2 - held / dx - std::sqrt(square(above.c2) + square(held / dx));
  EXPECT_GT(gamma_min, above.c1);
  const ForceInterval none = eba_interval(dx, held, above);
  EXPECT_GT(none.lo, none.hi);
  Random random(15);
  for (int n = 0; n < 200000; ++n) {
    const AxisCase a = random_case(random);
    const ForceInterval allowed = eba_interval(a.dx, a.held, a.c);
    EXPECT_LE(allowed.lo, allowed.hi + 1e-15 * std::abs(allowed.hi));
  }
}

TEST(EbaAxis, WithoutMovementTheForceCannotGrow) {
  const EbaConstants c{.c1 = 500.0, .c2 = 500.0};
  for (const double dx : {0.0, -0.0})
    for (const double held : {0.0, -0.0, 3.0, -3.0})
      for (const double command : {0.0, -0.0, 1.0, -1.0, 10.0, -10.0})
        EXPECT_EQ(eba_axis(command, dx, held, c),
                  std::clamp(command, -std::abs(held), std::abs(held)));
}

TEST(EbaAxis, SmallAndLargeNumbersStayInOrder) {
  const double least = std::numeric_limits<double>::denorm_min(),
               small = std::numeric_limits<double>::min();
  const double values[] = {0.0,     -0.0, least, -least, small, -small, 1e-200,
                           -1e-200, 1e-9, -1e-9, 1.0,    -1.0,  1e12,   -1e12};
  for (const double c1 : {0.0, least, 1e-100, 1.0, 1e6, 1e100})
    for (const double share : {0.0, 0.5, 1.0})
      for (const double dx : values)
        for (const double held : values) {
          const EbaConstants c{.c1 = c1, .c2 = share * c1};
          const ForceInterval allowed = eba_interval(dx, held, c);
          ASSERT_FALSE(std::isnan(allowed.lo) || std::isnan(allowed.hi))
              << c1 << ' ' << dx << ' ' << held;
          // The energy condition alone always allows zero. The hold may require a part of the held
          // force.
          ASSERT_LE(allowed.lo, std::max(0.0, held + c1 * dx));
          ASSERT_GE(allowed.hi, std::min(0.0, held + c1 * dx));
          for (const double command : values) {
            const double f = eba_axis(command, dx, held, c);
            ASSERT_LE(std::abs(f),
                      std::max(std::abs(held) + 2.0 * c1 * std::abs(dx) * (1 + 1e-15), 0.0) *
                              (1 + 1e-15) +
                          least);
          }
        }
}

// Cancellation: c2 dx is so large that a - h loses all digits of the held force.
TEST(EbaAxis, NoCancellation) {
  const EbaConstants c{.c1 = 1e6, .c2 = 1e6};
  EXPECT_NEAR(eba_interval(1.0, 1e-6, c).lo, -5e-19, 1e-33);
  EXPECT_NEAR(eba_interval(-1.0, 1e-6, c).hi, 5e-19, 1e-33);
  EXPECT_EQ(eba_interval(1.0, 0.0, c).lo, 0.0);
  EXPECT_EQ(eba_interval(-1.0, 0.0, c).hi, 0.0);
}

}  // namespace
}  // namespace feltwire::eba_axis_test
