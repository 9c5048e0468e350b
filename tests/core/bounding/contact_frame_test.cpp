// Tests condition (C) of the contact-frame bound (docs/bounding.md) on each channel, and its closed
// forms.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "tests/core/contact_frame_fixture.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::contact_frame_test {
namespace {

using namespace test;

/// Returns a step of a bound that has just rendered `held`, starting at rest.
Bounded next(const BoundingConfig& c, const Command& held, const BoundingStep& step) {
  Bounding bounding(c);
  // A displacement that allows any force, split in the frame of `held`.
  BoundingStep allow;
  allow.displacement = Vec3(1e3, 1e3, 1e3);
  allow.rotation = Vec3(1e5, 1e5, 1e5);
  allow.command = held;
  if (const Vec3 u = direction(held.elastic); u.norm() > 0.0) {
    Vec3 across = u.cross(Vec3(0.3, -0.5, 0.8)).normalized();
    allow.displacement = 1e3 * (u + across);
  }
  const Command rendered = bounding.step(allow).rendered;
  EXPECT_NEAR((rendered.force() - held.force()).norm(), 0.0, 1e-9 * (1.0 + held.force().norm()));
  return bounding.step(step);
}

double square(double x) { return x * x; }

// Checks condition (C) numerically against its energy form on each channel.
TEST(ContactFrame, LawHoldsOnEachChannelOverSixDecades) {
  Random random(7);
  int cut = 0;
  for (int n = 0; n < test::rounds(200'000); ++n) {
    const Projection projection = n % 2 ? Projection::joint : Projection::cone;
    const Vec3 normal = random.direction();
    const double e = std::abs(random.decades(-3.0, 3.0));
    Vec3 friction = random.vector(-3.0, 3.0);
    friction -= friction.dot(normal) * normal;
    Command held{e * normal, friction, random.vector(-3.0, 3.0)};
    BoundingStep s;
    s.displacement = random.vector(-6.0, 0.0);
    s.rotation = random.vector(-4.0, 2.0);
    s.hold_time = kPeriod * random.uniform(0.0, 3.0);
    s.command = random_command(random);
    if (random.chance(0.3))
      s.command.elastic = random.vector(-3.0, 3.0).norm() * (random.chance(0.5) ? -normal : normal);
    const Bounded out = next(contact_frame(projection), held, s);

    const double credit = kPeriod / std::max(s.hold_time, kPeriod);
    const double dx_el = s.displacement.dot(normal);
    const Vec3 dx_fr = s.displacement - dx_el * normal;
    const auto budget = [&](double storage, double inflow, double travel, double c) {
      return storage + 2.0 * c * inflow + square(c * travel) * credit;
    };
    const double el = budget(square(e), -e * dx_el, dx_el, kColgate);
    const double fr = budget(friction.squaredNorm(), -friction.dot(dx_fr), dx_fr.norm(), kColgate);
    const double scale =
        square(e) + friction.squaredNorm() + square(kColgate * s.displacement.norm());
    EXPECT_LE(out.rendered.elastic.squaredNorm(), std::max(0.0, el) + 1e-11 * scale);
    EXPECT_LE(out.rendered.frictional.squaredNorm(), std::max(0.0, fr) + 1e-11 * scale);

    const double c_r = 2.0 * kRotationalDamping / kPeriod;
    const double tq =
        budget(held.torque.squaredNorm(), -held.torque.dot(s.rotation), s.rotation.norm(), c_r);
    EXPECT_LE(
        out.rendered.torque.squaredNorm(),
        std::max(0.0, tq) + 1e-11 * (held.torque.squaredNorm() + square(c_r * s.rotation.norm())));

    // The bound must take no more than the conditions require. Either a channel is at its bound, or
    // the command is rendered completely.
    const Vec3 u = direction(s.command.elastic);
    const double along_normal = s.command.frictional.dot(u);
    const Vec3 wanted_elastic = std::max(0.0, s.command.elastic.norm() + along_normal) * u;
    const Vec3 wanted_friction = s.command.frictional - along_normal * u;
    if (s.hold_time <= kPeriod) {
      const bool whole = (out.rendered.force() - wanted_elastic - wanted_friction).norm() <=
                         1e-9 * (wanted_elastic + wanted_friction).norm();
      const bool at_elastic = std::abs(out.rendered.elastic.squaredNorm() - el) <= 1e-9 * scale;
      const bool at_friction = std::abs(out.rendered.frictional.squaredNorm() - fr) <= 1e-9 * scale;
      EXPECT_TRUE(whole || at_elastic || at_friction);
      cut += !whole;
    }
  }
  EXPECT_GT(cut, 1000);
}

TEST(ContactFrame, JointKeepsTheDirectionExactly) {
  Random random(8);
  Bounding bounding(contact_frame(Projection::joint));
  int cut = 0;
  for (int n = 0; n < test::rounds(100'000); ++n) {
    BoundingStep s{random.vector(-6.0, -2.0), random.vector(-4.0, 0.0), kPeriod,
                   random_command(random)};
    // Orthogonal parts are required here, because the bound removes the pulling part of a command.
    s.command.frictional -= along(s.command.frictional, direction(s.command.elastic));
    const Bounded out = bounding.step(s);
    if (out.rendered.force().norm() > 0.0) {
      EXPECT_LT(angle(out.rendered.force(), s.command.force()), 1e-12);
      EXPECT_LE(out.rendered.force().norm(), s.command.force().norm() * (1.0 + 1e-12));
      cut += out.active;
    }
    if (out.rendered.torque.norm() > 0.0) {
      EXPECT_LT(angle(out.rendered.torque, s.command.torque), 1e-12);
    }
  }
  EXPECT_GT(cut, 1000);
}

TEST(ContactFrame, ConeKeepsTheNormalForceAndFrictionInItsCone) {
  Random random(9);
  Bounding joint(contact_frame(Projection::joint)), cone(contact_frame(Projection::cone));
  int more_normal_force = 0;
  for (int n = 0; n < test::rounds(100'000); ++n) {
    const double mu = random.uniform(0.0, 2.0);
    const Vec3 normal = random.direction();
    const double e = std::abs(random.decades(-3.0, 2.0));
    Vec3 friction = random.direction();
    friction =
        mu * e * random.uniform(0.0, 1.0) * (friction - friction.dot(normal) * normal).normalized();
    const BoundingStep s{
        random.vector(-6.0, -2.0), Vec3::Zero(), kPeriod, {e * normal, friction, Vec3::Zero()}};
    const Command j = joint.step(s).rendered, c = cone.step(s).rendered;
    EXPECT_LE(c.frictional.norm(), mu * c.elastic.norm() * (1.0 + 1e-12));
    if (c.elastic.norm() > 0.0) {
      EXPECT_LT(angle(c.elastic, normal), 1e-12);
    }
    joint.set_held(c);
    cone.set_held(c);  // The next step must start from the same stored energy.
    more_normal_force += c.elastic.norm() > 1.001 * j.elastic.norm();
  }
  EXPECT_GT(more_normal_force, 1000);
}

TEST(ContactFrame, ContactDampingCountsAsElasticAndNeverPulls) {
  Bounding bounding(contact_frame());
  BoundingStep s;
  s.displacement = Vec3(-0.1, -0.1, 0);
  s.command = {Vec3(0, 3, 0), Vec3(1, -1, 0), Vec3::Zero()};
  Bounded out = bounding.step(s);
  EXPECT_EQ(out.rendered.elastic.y(), 2.0);
  EXPECT_EQ(out.rendered.frictional.x(), 1.0);
  EXPECT_EQ(out.rendered.frictional.y(), 0.0);
  s.command.frictional = Vec3(1, -5, 0);  // This friction alone would pull.
  out = bounding.step(s);
  EXPECT_EQ(out.rendered.force().y(), 0.0);
  EXPECT_EQ(out.rendered.elastic.norm(), 0.0);
}

// Orthogonalization leaves a friction of some 1e-17 N. The bound must ignore this rounding error.
// Without tangential movement, the joint factor would otherwise remove the complete force.
TEST(ContactFrame, RoundingIsNoFriction) {
  Random random(10);
  for (int n = 0; n < 10000; ++n) {
    Bounding bounding(contact_frame(Projection::joint));
    const Vec3 normal = random.direction();
    const BoundingStep s{
        -0.1 * normal, Vec3::Zero(), kPeriod, {3.0 * normal, -0.7 * normal, Vec3::Zero()}};
    EXPECT_LT((bounding.step(s).rendered.force() - 2.3 * normal).norm(), 1e-12);
  }
}

TEST(ContactFrame, ContactLostDropsTheForceAtOnce) {
  Bounding bounding(contact_frame());
  BoundingStep s;
  s.displacement = Vec3(0, -0.01, 0);
  s.command.elastic = Vec3(0, 5, 0);
  EXPECT_GT(bounding.step(s).rendered.elastic.y(), 0.0);
  s.displacement = Vec3(0, 1e-6, 0);
  s.command = {};
  EXPECT_EQ(bounding.step(s).rendered.force().norm(), 0.0);
}

/// Returns the least |rendered| / |commanded| while a hand presses `depth` into a spring. If
/// `release` is set, the hand also moves out again.
double least_ratio(double stiffness, bool release) {
  Bounding bounding(contact_frame());
  const Vec3 up = Vec3(1, 2, 2) / 3.0;
  const int steps = 2000;
  double before = 0.0, least = 1.0;
  for (int n = 1; n < (release ? steps : steps / 2); ++n) {
    const double depth = 0.01 * std::sin(std::numbers::pi * n / steps);
    BoundingStep s{-(depth - before) * up,
                   Vec3::Zero(),
                   kPeriod,
                   {stiffness * depth * up, Vec3::Zero(), Vec3::Zero()}};
    least = std::min(least, bounding.step(s).rendered.force().norm() / (stiffness * depth));
    before = depth;
  }
  return least;
}

TEST(ContactFrame, ASpringIsRenderedUndiminishedUpToColgatesLimit) {
  EXPECT_NEAR(least_ratio(kColgate, true), 1.0, 1e-6);
  for (const double share : {0.01, 0.1, 0.5, 0.99})
    EXPECT_NEAR(least_ratio(share * kColgate, false), 1.0, 1e-6);
  EXPECT_LT(least_ratio(1.01 * kColgate, false), 0.995);
  EXPECT_NEAR(least_ratio(2.0 * kColgate, false), 0.5, 1e-3);
}

// Minimal storage keeps energy for one force only, but a soft spring stores more than F^2 / (2 c).
// On release the force therefore falls with the slope c instead of k (docs/bounding.md, known
// weakness).
TEST(ContactFrame, ASoftSpringIsForgottenOnRelease) {
  EXPECT_LT(least_ratio(0.25 * kColgate, true), 0.01);
}

/// Returns the number of samples of free movement until the debt is repaid.
int samples_to_repay(Bounding& bounding, BoundingStep free) {
  free.hold_time = kPeriod;
  free.command = {};
  int steps = 1;
  while (bounding.step(free).in_debt && steps < 100000) ++steps;
  return steps;
}

TEST(ContactFrame, ADebtIsRepaidByTheDampingExactly) {
  Bounding bounding(contact_frame());
  BoundingStep s;
  const Vec3 up(0, 1, 0);
  s.displacement = -0.001 * up;
  s.command.elastic = 1.0 * up;  // The bound allows c * 1 mm = 1 N.
  EXPECT_NEAR(bounding.step(s).rendered.elastic.y(), 1.0, 1e-12);
  // In a hold of 10 T, the hand moves along the force by the distance that extracts the most
  // energy: 1 N * h / (2 b).
  s.hold_time = 10 * kPeriod;
  s.displacement = greediest(up, s.hold_time, kDamping);
  const double debt = kDamping / s.hold_time * s.displacement.squaredNorm() - s.displacement.y() +
                      kPeriod / (4.0 * kDamping);
  EXPECT_LT(debt, 0.0);
  Bounded out = bounding.step(s);
  EXPECT_TRUE(out.in_debt);
  EXPECT_EQ(out.rendered.force().norm(), 0.0);
  // Free movement repays b/T dx^2 per sample.
  s.displacement = Vec3(1e-4, 0, 0);
  const double each = kDamping / kPeriod * s.displacement.squaredNorm();
  EXPECT_NEAR(samples_to_repay(bounding, s) * each, -debt, 1.5 * each);
  s.hold_time = kPeriod;
  s.displacement = -0.001 * up;
  s.command.elastic = 1.0 * up;
  EXPECT_NEAR(bounding.step(s).rendered.elastic.y(), 1.0, 1e-12);
}

// The worst movement over a hold of h extracts f^2 h / (4 b), which is h/T times the stored energy.
// The debt is this energy minus the stored energy.
TEST(ContactFrame, AMovementNotKnownOverALongHoldOwesTheWorst) {
  for (const bool rotation : {false, true}) {
    const double b = rotation ? kRotationalDamping : kDamping, c = 2.0 * b / kPeriod;
    const Vec3 none = Vec3::Zero(), press(0, -1e-3, 0), held(0, c * 1e-3, 0),
               unknown(0, std::nan(""), 0);
    const auto step = [&](const Vec3& movement, double hold_time) {
      return rotation ? BoundingStep{none, movement, hold_time, {none, none, held}}
                      : BoundingStep{movement, none, hold_time, {held, none, none}};
    };
    Bounding bounding(contact_frame());
    EXPECT_FALSE(bounding.step(step(press, kPeriod)).active);
    EXPECT_TRUE(bounding.step(step(unknown, 10 * kPeriod)).in_debt);
    const double debt = 9.0 * held.squaredNorm() * kPeriod / (4.0 * b);
    const Vec3 away(2e-5, 0, 0);
    const double each = b / kPeriod * away.squaredNorm();
    EXPECT_NEAR(samples_to_repay(bounding, step(away, kPeriod)) * each, debt, 1.5 * each);
    EXPECT_FALSE(bounding.step(step(press, kPeriod)).active);

    // In a hold of at most T, the stored energy covers the worst movement. No debt arises.
    EXPECT_FALSE(bounding.step(step(unknown, kPeriod)).in_debt);
    EXPECT_FALSE(bounding.step(step(press, kPeriod)).active);
  }
}

TEST(ContactFrame, HoldsShorterThanThePeriodEarnNoMoreThanThePeriod) {
  for (const double share : {0.0, 0.1, 0.5, 1.0}) {
    Bounding bounding(contact_frame());
    BoundingStep s;
    s.displacement = Vec3(0, -1e-3, 0);
    s.hold_time = share * kPeriod;
    s.command.elastic = Vec3(0, 100, 0);
    EXPECT_DOUBLE_EQ(bounding.step(s).rendered.elastic.y(), kColgate * 1e-3);
  }
  Bounding bounding(contact_frame());
  BoundingStep s;
  s.displacement = Vec3(0, -1e-3, 0);
  s.hold_time = 4.0 * kPeriod;  // A quarter of the damping gives half the force.
  s.command.elastic = Vec3(0, 100, 0);
  EXPECT_DOUBLE_EQ(bounding.step(s).rendered.elastic.y(), 0.5 * kColgate * 1e-3);
}

// Friction is held without an elastic force. Then a normal parallel to the friction appears. The
// bound must split the held force in the new frame. Otherwise the elastic channel would use damping
// that friction has already used.
TEST(ContactFrame, FrictionHeldWithoutContactIsSplitInTheNewFrame) {
  Bounding bounding(contact_frame());
  BoundingStep s;
  s.displacement = Vec3(-1e-3, 0, 0);
  s.command.frictional = Vec3(1, 0, 0);
  EXPECT_DOUBLE_EQ(bounding.step(s).rendered.frictional.x(), 1.0);
  // extracts the complete stored energy
  s.displacement = greediest(Vec3(1, 0, 0), kPeriod, kDamping);
  s.command = {Vec3(10, 0, 0), Vec3(0, 10, 0), Vec3::Zero()};
  EXPECT_NEAR(bounding.step(s).rendered.force().norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace feltwire::contact_frame_test
