// Compares each published law with a few samples that are computed by hand.

#include "sim/published_laws/published_laws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "core/bounding/bounding.hpp"

namespace feltwire::published_laws_test {
namespace {

constexpr double kPeriod = 1e-3, kDamping = 0.5, kQuantum = 1e-5;

BoundingConfig config() {
  BoundingConfig c;
  c.period = kPeriod;
  c.damping = kDamping;
  c.quantum = kQuantum;
  c.max_force = 8.0;
  return c;
}

/// A hand moves `inward` [m] deeper into a surface with the normal +z. The surface commands `force`
/// [N].
double press(Bounding& bounding, double inward, double force) {
  BoundingStep s;
  s.displacement.z() = -inward;
  s.hold_time = kPeriod;
  s.command.elastic.z() = force;
  return bounding.step(s).rendered.force().z();
}

TEST(PublishedLaws, AreFoundByStudiesAndUnknownToTheRegistry) {
  for (const BoundingMethod& m : published_laws()) {
    EXPECT_EQ(&law(m.name), &m);
    EXPECT_THROW(bounding_method(m.name), std::invalid_argument) << m.name;
    EXPECT_EQ(Bounding(m, config()).config().mode, m.name);
  }
  EXPECT_EQ(&law("contact_frame"), &bounding_method("contact_frame"));
  EXPECT_THROW(law("nothing"), std::invalid_argument);
}

TEST(PublishedLaws, NoneCommandsOrBendsWhatIsNotThere) {
  for (const BoundingMethod& m : published_laws()) {
    Bounding bounding(m, config());
    for (int n = 0; n < 20; ++n) EXPECT_EQ(press(bounding, 0.0, 0.0), 0.0) << m.name;
    BoundingStep s;
    s.hold_time = kPeriod;
    s.command = {Vec3(0, 0, 2.0), Vec3(1.0, 0, 0), Vec3::Zero()};
    s.displacement = Vec3(-1e-4, 0, -1e-4);
    const Vec3 force = bounding.step(s).rendered.force();
    if (m.name != "two_layer_tank") {  // The damper of this method acts against the movement.
      EXPECT_NEAR(force.cross(s.command.force()).norm(), 0.0, 1e-12) << m.name;
    }
  }
}

TEST(TdpcExact, PaysBackWhatTheHoldGaveAway) {
  Bounding bounding(law("tdpc_exact"), config());
  EXPECT_EQ(press(bounding, 0.0, 2.0), 2.0);
  // When the hand moves in by 0.1 mm against 2 N, the law gets 0.2 mJ. When the hand moves out by
  // 0.2 mm with 3 N, 0.4 mJ are missing. The damper removes 0.4 mJ / 0.2 mm = 2 N.
  EXPECT_EQ(press(bounding, 1e-4, 3.0), 3.0);
  EXPECT_NEAR(press(bounding, -2e-4, 1.0), 1.0 - 2.0, 1e-12);
  // The law gets the force that was held instead.
  bounding.set_held({});
  EXPECT_NEAR(press(bounding, -4e-4, 1.0), 1.0 - 1.0, 1e-12);
}

TEST(BoundedOutput, ActsOnlyBeyondItsAllowance) {
  BoundingConfig c = config();
  c.max_force = 100.0;
  Bounding bounding(law("bounded_output"), c);
  press(bounding, 0.0, 10.0);
  EXPECT_EQ(press(bounding, -4e-4, 10.0), 10.0) << "4 mJ are given away";
  EXPECT_NEAR(press(bounding, -4e-4, 10.0), 10.0 - 3e-3 / 4e-4, 1e-9) << "8 mJ: 3 too many";
}

TEST(ForceAugmentation, RisesByItsLowStiffnessAndByATenthAtEveryPress) {
  Bounding bounding(law("force_augmentation"), config());  // k0 = 1 kN/m
  // The first press gives 0.1 N by the spring, plus a tenth of the difference to 5 N.
  EXPECT_NEAR(press(bounding, 1e-4, 5.0), 0.1 + 0.49, 1e-12);
  EXPECT_NEAR(press(bounding, 1e-4, 5.0), 0.69, 1e-12) << "still the same press";
  EXPECT_NEAR(press(bounding, 0.0, 5.0), 0.69, 1e-12);
  EXPECT_NEAR(press(bounding, 1e-4, 5.0), 0.79, 1e-12) << "a rest is no turn";
  EXPECT_NEAR(press(bounding, -1e-4, 5.0), 0.69, 1e-12);
  EXPECT_NEAR(press(bounding, 1e-4, 5.0), 0.79 + 0.421, 1e-12) << "the next press";
  EXPECT_EQ(press(bounding, 0.0, 0.2), 0.2) << "never above the surface's own";
  EXPECT_EQ(press(bounding, 0.0, 0.0), 0.0);
  EXPECT_EQ(press(bounding, 0.0, 5.0), 0.0) << "a new contact begins anew";
}

TEST(ForceAugmentation, WithItsTransientItLandsOnTheWholeStiffness) {
  Bounding bounding(law("force_augmentation_transient"), config());  // k0 = 1 kN/m
  EXPECT_EQ(press(bounding, 1e-4, 4.0), 4.0);
  EXPECT_EQ(press(bounding, 1e-4, 5.0), 5.0);
  EXPECT_EQ(press(bounding, 0.0, 5.0), 5.0) << "a rest is no turn";
  EXPECT_NEAR(press(bounding, -1e-4, 8.0), 4.9, 1e-12) << "the transient is over";
  EXPECT_NEAR(press(bounding, 1e-4, 8.0), 5.0 + 0.3, 1e-12) << "a press of the low stiffness";
  EXPECT_EQ(press(bounding, 0.0, 0.0), 0.0);
  EXPECT_EQ(press(bounding, 1e-4, 4.0), 4.0) << "a new contact lands anew";
}

TEST(PositionMemory, TheWayOutStaysBelowTheWayIn) {
  Bounding bounding(law("position_memory"), config());
  // The hand moves in by ten cells on a spring, one cell per sample. The force of a cell is the
  // force at its beginning.
  for (int n = 0; n <= 10; ++n) EXPECT_EQ(press(bounding, n ? kQuantum : 0.0, 0.1 * n), 0.1 * n);
  for (int n = 9; n >= 1; --n)
    EXPECT_NEAR(press(bounding, -kQuantum, 0.1 * n), 0.1 * (n - 1), 1e-6)
        << "of the cell that is left next";
}

TEST(PositionMemory, AQuickHandIsBoundedByAllThatItPasses) {
  Bounding bounding(law("position_memory"), config());
  for (int n = 0; n <= 10; ++n) press(bounding, n ? kQuantum : 0.0, 0.1 * n);
  EXPECT_NEAR(press(bounding, -4 * kQuantum, 5.0), 0.2, 1e-6) << "cells 5 to 2";
  EXPECT_EQ(press(bounding, kQuantum, 5.0), 5.0) << "in again: as commanded";
}

TEST(TwoLayerTank, PaysForNoMoreThanTheHandPutIn) {
  Bounding bounding(law("two_layer_tank"), config());
  EXPECT_EQ(press(bounding, 0.0, 3.0), 0.0) << "empty";
  // The damper is b/2 while the tank is empty: 0.25 N s/m at 0.1 m/s. The next sample fills the
  // tank.
  EXPECT_NEAR(press(bounding, 1e-4, 0.0), 0.25 * 0.1, 1e-12);
  BoundingStep s;
  s.hold_time = kPeriod;
  s.displacement = Vec3(0, 0, -1e-4);
  const double level = 0.25 * 0.1 * 1e-4;  // [J] the hand's work against the damper
  s.command.elastic.z() = 3.0;
  const double paid = level / 1e-4;
  const double damper = 0.25 * (1.0 - level / 5e-3) * 0.1;
  EXPECT_NEAR(bounding.step(s).rendered.force().z(), paid + damper, 1e-12);
}

}  // namespace
}  // namespace feltwire::published_laws_test
