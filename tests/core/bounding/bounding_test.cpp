// Tests the requirements that every bounding method must meet.

#include "core/bounding/bounding.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/bounding/port_energy.hpp"
#include "tests/core/in_arithmetic.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::bounding_test {
namespace {

using test::config;
using test::Random;
using test::random_command;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPeriod = test::kModePeriod;

const std::vector<std::string_view> kModes = bounding_method_names();
/// Methods that never render more than the command.
constexpr std::string_view kLimiters[] = {
    "none", "total_energy", "per_axis", "per_axis_projected", "contact_frame", "energy_tank"};

std::string reason(const BoundingConfig& c) {
  try {
    Bounding bounding(c);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Bounding, BadConfigurationsAreRejectedByName) {
  const auto with = [](auto change) {
    std::string all;
    for (const std::string_view mode : kModes) {
      BoundingConfig c = config(mode);
      change(c);
      const std::string text = reason(c);
      if (!all.empty() && all != text) return "modes differ: " + all + " / " + text;
      all = text;
    }
    return all;
  };
  EXPECT_EQ(with([](BoundingConfig&) {}), "accepted");
  for (const double bad : {kNan, kInfinity, -1.0}) {
    EXPECT_THAT(with([&](BoundingConfig& c) { c.period = bad; }), HasSubstr("period"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.damping = bad; }), HasSubstr("damping"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.rotational_damping = bad; }),
                HasSubstr("rotational damping"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.c1 = bad; }), HasSubstr("c1"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.c2 = bad; }), HasSubstr("c2"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.c1_rotation = bad; }), HasSubstr("c1 (rotation)"));
    EXPECT_THAT(with([&](BoundingConfig& c) { c.c2_rotation = bad; }), HasSubstr("c2 (rotation)"));
  }
  for (const double bad : {kNan, 0.0, -1.0})
    EXPECT_THAT(with([&](BoundingConfig& c) { c.max_force = bad; }), HasSubstr("max force"));
  for (const double bad : {kNan, -1.0})
    EXPECT_THAT(with([&](BoundingConfig& c) { c.max_torque = bad; }), HasSubstr("max torque"));
  EXPECT_THAT(with([](BoundingConfig& c) { c.period = 0.0; }), HasSubstr("period"));
  EXPECT_THAT(with([](BoundingConfig& c) { c.period = 1e-300; }), HasSubstr("too short"));
  EXPECT_THAT(with([](BoundingConfig& c) { c.c1 = 100.0, c.c2 = 100.1; }), HasSubstr("lower c2"));
  EXPECT_THAT(with([](BoundingConfig& c) { c.c2 = 500.1; }), HasSubstr("lower c2"));
  EXPECT_THAT(with([](BoundingConfig& c) { c.c2_rotation = 1.1; }), HasSubstr("c2 (rotation)"));
  EXPECT_EQ(with([](BoundingConfig& c) { c.c1 = 100.0, c.c2 = 100.0; }), "accepted");
  EXPECT_EQ(with([](BoundingConfig& c) { c.damping = c.rotational_damping = 0.0; }), "accepted");
}

TEST(Bounding, NamesGoBothWays) {
  for (const std::string_view mode : kModes) EXPECT_EQ(bounding_method(mode).name, mode);
  EXPECT_EQ(projection(name(Projection::joint)), Projection::joint);
  EXPECT_EQ(projection(name(Projection::cone)), Projection::cone);
  try {
    bounding_method("per-axis");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), HasSubstr("per-axis"));
    for (const auto known : bounding_method_names())
      EXPECT_THAT(e.what(), HasSubstr(std::string(known)));
  }
  EXPECT_THROW(projection(""), std::invalid_argument);
}

TEST(Bounding, WhatIsNoNumberGivesNoForce) {
  const double bad[] = {kNan, kInfinity, -kInfinity, 1e300, -1e300, 1.001e12};
  for (const std::string_view mode : kModes)
    for (const double x : bad)
      for (int input = 0; input < 6; ++input) {
        Bounding bounding(config(mode));
        BoundingStep good;
        good.displacement = Vec3(-1e-3, -2e-3, 1e-3);
        good.rotation = Vec3(0.1, -0.2, 0.1);
        good.hold_time = kPeriod;
        good.command = {Vec3(0.1, 0.2, 0), Vec3(0.1, -0.05, 0), Vec3(-0.01, 0.01, 0)};
        EXPECT_FALSE(bounding.step(good).refused);
        EXPECT_GT(bounding.step(good).rendered.force().norm(), 0.0);
        BoundingStep s = good;
        Vec3* vectors[] = {&s.displacement, &s.rotation, &s.command.elastic, &s.command.frictional,
                           &s.command.torque};
        if (input < 5) {
          (*vectors[input])[static_cast<int>(std::abs(std::fmod(x, 3.0)) > 1.0)] = x;
        } else {
          if (x == -1e300) continue;  // A hold shorter than T is valid.
          s.hold_time = x;
        }
        const Bounded out = bounding.step(s);
        EXPECT_TRUE(out.refused) << mode << ' ' << input << ' ' << x;
        EXPECT_EQ(out.rendered.force(), Vec3::Zero());
        EXPECT_EQ(out.rendered.torque, Vec3::Zero());
        bounding.set_held({Vec3(x, x, x), Vec3(0, x, 0), Vec3(0, 0, x)});
        for (int n = 0; n < 10; ++n) {
          const Command after = bounding.step(good).rendered;
          EXPECT_TRUE(after.finite());
          // A virtual coupling renders its own spring instead of the scene's command.
          if (mode == "virtual_coupling") continue;
          EXPECT_LE(after.force().norm(), good.command.force().norm() * (1.0 + 1e-12));
        }
      }
}

// The bound must assume the worst case. With 1 N for 5 T, the hand can extract 2 mJ more than the
// port dissipates. For a hold of T, the same movement would count as a gain.
TEST(Bounding, AHoldTimeThatIsNoNumberEarnsNoCredit) {
  for (const std::string_view mode : {"contact_frame", "energy_tank"})
    for (const double told : {kNan, kInfinity, -kInfinity, 1e300}) {
      Bounding bounding(config(mode));  // c = 1000 N/m
      BoundingStep press{Vec3(-1e-3, 0, 0), Vec3::Zero(), kPeriod, {}};
      press.command.elastic.x() = 1.0;
      ASSERT_NEAR(bounding.step(press).rendered.elastic.x(), 1.0, 1e-12) << mode;
      const BoundingStep pulled{Vec3(5e-3, 0, 0), Vec3::Zero(), told, press.command};
      EXPECT_TRUE(bounding.step(pulled).in_debt) << mode << ' ' << told;
      EXPECT_EQ(bounding.step(press).rendered.force(), Vec3::Zero()) << mode << ' ' << told;
    }
}

template <class Real>
void stays_finite(const BoundingConfig& c) {
  using Vector = Vector3<Real>;
  BasicBounding<Real> bounding = test::bounding_in<Real>(c);
  for (const Real way : {Real(0), Real(1e6), Real(-1e6), Real(1e-40), Real(0)}) {
    BasicBoundingStep<Real> s{
        Vector::Constant(way), Vector::Constant(way), static_cast<Real>(c.period), {}};
    s.command = {Vector::Constant(Real(-1e12)), Vector::Unit(1), Vector::Constant(Real(1e12))};
    EXPECT_TRUE(bounding.step(s).rendered.finite()) << c.mode << ' ' << way;
  }
}

// A stiffness or a period beyond the range of float would make products infinite. Infinity times
// zero is not a number.
TEST(Bounding, TheLargestConfigurationIsFiniteInFloat) {
  for (const std::string_view mode : kModes) {
    BoundingConfig c = config(mode);
    c.period = 1e-12;
    c.damping = c.rotational_damping = 5e5;  // 2 b / T = 1e18 N/m
    stays_finite<double>(c);
    stays_finite<float>(c);
    c.damping = 5.1e5;
    EXPECT_THAT(reason(c), HasSubstr("damping over period is too large")) << mode;
    c.damping = c.rotational_damping = 0.0;
    c.period = 0.9e-12;
    EXPECT_THAT(reason(c), HasSubstr("too short")) << mode;
  }
}

TEST(Bounding, RandomBitsNeverComeOutAsAnythingButAForce) {
  Random random(31);
  const double strange[] = {0.0,  -0.0,  kNan, kInfinity, -kInfinity, 1e-320, -1e-320,
                            1e12, -1e12, 1e6,  -1e6,      1e300,      1.0};
  const auto vector = [&] {
    Vec3 v = random.vector(-12, 6);
    if (random.chance(0.2))
      v[static_cast<int>(random.uniform(0, 3))] = strange[static_cast<int>(random.uniform(0, 13))];
    return v;
  };
  for (const std::string_view mode : kModes) {
    BoundingConfig c = config(mode);
    c.max_force = 5.0;
    c.max_torque = 0.2;
    Bounding bounding(c);
    for (int n = 0; n < test::rounds(50'000); ++n) {
      const BoundingStep s{vector(), vector(), vector().x(), {vector(), vector(), vector()}};
      const Bounded out = bounding.step(s);
      ASSERT_TRUE(out.rendered.finite()) << mode;
      ASSERT_LE(out.rendered.force().norm(), 5.0 * (1.0 + 1e-15 * 8)) << mode;
      ASSERT_LE(out.rendered.torque.norm(), 0.2 * (1.0 + 1e-15 * 8)) << mode;
      if (out.refused) {
        ASSERT_EQ(out.rendered.force(), Vec3::Zero());
      }
      if (random.chance(0.1)) bounding.set_held({vector(), vector(), vector()});
    }
  }
}

TEST(Bounding, SaturationKeepsTheDirectionAndSaysSo) {
  for (const std::string_view mode : kLimiters) {
    BoundingConfig c = config(mode);
    c.max_force = 2.0;
    c.max_torque = 0.01;
    Bounding bounding(c);
    BoundingStep s;
    s.displacement = Vec3(-0.1, -0.1, 0);
    s.rotation = Vec3(0, 0, -1);
    s.command = {Vec3(0, 4, 0), Vec3(3, 0, 0), Vec3(0, 0, 0.5)};
    const Bounded out = bounding.step(s);
    EXPECT_TRUE(out.saturated);
    EXPECT_FALSE(out.active) << mode;
    EXPECT_NEAR((out.rendered.force() - Vec3(1.2, 1.6, 0)).norm(), 0.0, 1e-12) << mode;
    EXPECT_NEAR(out.rendered.torque.z(), 0.01, 1e-15);
    s.command = 0.1 * s.command;
    s.command.torque.setZero();
    EXPECT_FALSE(bounding.step(s).saturated);
  }
}

TEST(Bounding, WithoutRotationThereIsNoTorqueAndNobodyLooksAtIt) {
  for (const std::string_view mode : kLimiters) {
    BoundingConfig c = config(mode);
    c.rotation = false;
    c.max_torque = 0.0;
    Bounding bounding(c);
    BoundingStep s;
    s.displacement = Vec3(-0.1, 0, 0);
    s.rotation = Vec3(kNan, 1, 2);
    s.command = {Vec3(1, 0, 0), Vec3::Zero(), Vec3(1, kInfinity, 3)};
    const Bounded out = bounding.step(s);
    EXPECT_FALSE(out.refused);
    EXPECT_FALSE(out.saturated);
    EXPECT_EQ(out.rendered.force(), Vec3(1, 0, 0));
    EXPECT_EQ(out.rendered.torque, Vec3::Zero());
  }
}

TEST(Bounding, NoneIsTheIdentityAndOnlyThatNeedsNoDamping) {
  for (const std::string_view mode : kLimiters) {
    BoundingConfig c = config(mode, 0.0);
    c.rotational_damping = 0.0;
    Bounding bounding(c);
    BoundingStep s;
    // The movement is along the force, so no energy covers it.
    s.displacement = Vec3(0.1, 0.1, 0.1);
    s.command = {Vec3(1, 2, 3), Vec3(3, 2, 1), Vec3(1, 1, 1)};
    const Bounded out = bounding.step(s);
    EXPECT_EQ(out.active, mode != "none");
    if (mode == "none") {
      EXPECT_EQ(out.rendered.elastic, s.command.elastic);
      EXPECT_EQ(out.rendered.frictional, s.command.frictional);
      EXPECT_EQ(out.rendered.torque, s.command.torque);
    } else {
      EXPECT_EQ(out.rendered.force(), Vec3::Zero());
    }
  }
}

// Returns the violations under a hand that extracts the most energy from the held force. The
// observer compares f(n-1).dx(n) at the real port with b/T dx^2.
std::uint64_t violations(std::string_view mode) {
  std::uint64_t total = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    Bounding bounding(config(mode));
    PortEnergy port(0.5, 1e-3, kPeriod);
    Command held;
    for (int n = 0; n < 2000; ++n) {
      BoundingStep s{random.vector(-7, -3), random.vector(-5, -1), kPeriod, random_command(random)};
      if (random.chance(0.5)) {
        s.displacement = test::greediest(held.force(), kPeriod, 0.5);
        s.rotation = test::greediest(held.torque, kPeriod, 1e-3);
      }
      port.step(held, s.displacement, s.rotation, kPeriod);
      held = bounding.step(s).rendered;
      if (random.chance(0.3)) {
        held = random.uniform(0.0, 1.0) * held;
        bounding.set_held(held);
      }
    }
    total += port.violations();
  }
  return total;
}

// Conditions (E) and (H) of docs/bounding.md together make the real port passive. The default
// method is passive too. The other methods are counterexamples.
TEST(Bounding, OnlyPerAxisAndContactFrameKeepTheRealPortPassive) {
  EXPECT_EQ(violations("per_axis"), 0u);
  EXPECT_EQ(violations("contact_frame"), 0u);
  EXPECT_GT(violations("none"), 0u);
  EXPECT_GT(violations("total_energy"), 0u);
}

TEST(Bounding, SameInputSameBits) {
  for (const std::string_view mode : kModes) {
    const auto run = [&] {
      Random random(42);
      Bounding bounding(config(mode));
      std::vector<double> out;
      for (int n = 0; n < 5000; ++n) {
        const BoundingStep s{random.vector(-6, -2), random.vector(-4, 0),
                             kPeriod * random.uniform(0, 3), random_command(random)};
        const Command r = bounding.step(s).rendered;
        for (const Vec3& v : {r.elastic, r.frictional, r.torque})
          out.insert(out.end(), v.begin(), v.end());
      }
      return out;
    };
    const std::vector<double> first = run(), second = run();
    EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace feltwire::bounding_test
