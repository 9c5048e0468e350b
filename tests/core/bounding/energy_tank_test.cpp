// Tests closed forms of the energy tank, and its gain over the contact frame.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/contact_frame_fixture.hpp"

namespace feltwire::energy_tank_test {
namespace {

using namespace test;

BoundingConfig tank() {
  BoundingConfig c = contact_frame(Projection::cone);
  c.mode = "energy_tank";
  return c;
}
/// Moves `in` [m] into the surface z < 0 and `along` [m] in x, and commands both forces.
Command push(Bounding& bounding, double in, double along, double elastic, double friction = 0.0) {
  return bounding
      .step({Vec3(along, 0, -in),
             Vec3::Zero(),
             kPeriod,
             {Vec3(0, 0, elastic), Vec3(-friction, 0, 0), Vec3::Zero()}})
      .rendered;
}

TEST(EnergyTank, FromRestItGivesColgatesSlope) {
  // E = b/T dx^2, |f| = sqrt(4 b E / T) = 2 b/T dx. A held F adds F dx to the next sample's E.
  Bounding bounding(tank());
  EXPECT_NEAR(push(bounding, 1e-3, 0.0, 1e6).elastic.z(), kColgate * 1e-3, 1e-12);
  EXPECT_NEAR(push(bounding, 2e-3, 0.0, 1e6).elastic.z(), kColgate * 3e-3, 1e-12);
  EXPECT_NEAR(push(bounding, 0.0, 0.0, 1e6).elastic.z(), kColgate * 3e-3, 1e-12);
  EXPECT_NEAR(push(bounding, -1e-3, 0.0, 1e6).elastic.z(), kColgate * 2e-3, 1e-12);
}

TEST(EnergyTank, KeepsWhatTheDampingBurnedWhileTheContactLasts) {
  // Each of 100 movements of 1 mm dissipates b/T dx^2. At 0.1 N a movement in stores 0.1 mJ, and a
  // movement out takes 0.1 mJ. The first movement in holds no force and stores nothing.
  Bounding bounding(tank());
  for (int n = 0; n < 100; ++n) push(bounding, n % 2 ? -1e-3 : 1e-3, 0.0, 0.1);
  const double energy = 100 * kDamping / kPeriod * 1e-6 - 0.1e-3;
  EXPECT_NEAR(push(bounding, 0.0, 0.0, 1e6).elastic.z(),
              std::sqrt(4.0 * kDamping / kPeriod * energy), 1e-9);
}

TEST(EnergyTank, ALostContactEmptiesIt) {
  Bounding bounding(tank());
  for (int n = 0; n < 100; ++n)
    push(bounding, n % 2 ? -1e-3 : 1e-3, n % 2 ? 1e-3 : -1e-3, 0.1, 0.1);
  bounding.step({Vec3::Zero(), Vec3::Zero(), kPeriod, {}});
  const Command after = push(bounding, 1e-3, 0.0, 1e6);
  EXPECT_NEAR(after.elastic.z(), kColgate * 1e-3, 1e-12);
}

TEST(EnergyTank, FrictionFillsItsOwnOnly) {
  Bounding bounding(tank());
  for (int n = 0; n < 1000; ++n) push(bounding, n == 0 ? 1e-5 : 0.0, 1e-4, 1e-3, 2.0);
  // The elastic tank holds the energy that 10 um dissipated. A movement of 1 mm dissipates more,
  // and pressing 1 mN adds 1 uJ.
  const double energy = kDamping / kPeriod * (1e-10 + 1e-6) + 1e-6;
  EXPECT_NEAR(push(bounding, 1e-3, 0.0, 1e6).elastic.z(),
              std::sqrt(4.0 * kDamping / kPeriod * energy), 1e-9);
}

TEST(EnergyTank, AnOverlongHoldIsOwed) {
  Bounding bounding(tank());
  push(bounding, 1e-3, 0.0, 1e6);  // 1 N
  const Bounded out = bounding.step(
      {Vec3(0, 0, 0.1), Vec3::Zero(), 1.0, {Vec3(0, 0, 1), Vec3::Zero(), Vec3::Zero()}});
  EXPECT_TRUE(out.in_debt);
  EXPECT_EQ(out.rendered.force(), Vec3::Zero());
  // The tank stored 0.5 mJ, the port delivered 100 mJ, and the damping dissipated 5 mJ. The debt is
  // 94.5 mJ. A movement of 20 mm dissipates 200 mJ.
  EXPECT_NEAR(push(bounding, 20e-3, 0.0, 1e6).elastic.z(),
              std::sqrt(4.0 * kDamping / kPeriod * (0.2 - 0.0945)), 1e-9);
}

// On the same history, the tank never allows less than the contact frame, because it keeps the
// energy that the contact frame discards.
TEST(EnergyTank, AllowsAtLeastWhatTheContactFrameDoes) {
  double more = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Bounding frame(contact_frame(Projection::cone)), tanks(tank());
    double depth = 0.0;
    for (int n = 0; n < 2000; ++n) {
      const double in = random.decades(-6.0, -3.0);
      depth = std::min(depth + in, 0.01);
      const double elastic = 1500.0 * std::max(0.0, depth);
      const double along = random.decades(-6.0, -3.0);
      const double friction = 0.5 * elastic * (along > 0.0 ? 1.0 : -1.0);
      const Command a = push(frame, in, along, elastic, friction);
      const Command b = push(tanks, in, along, elastic, friction);
      ASSERT_GE(b.elastic.norm(), a.elastic.norm() * (1.0 - 1e-9)) << seed << " at " << n;
      ASSERT_GE(b.frictional.norm(), a.frictional.norm() * (1.0 - 1e-9)) << seed << " at " << n;
      more += b.elastic.norm() - a.elastic.norm();
      tanks.set_held(a);
    }
  }
  EXPECT_GT(more, 1.0);
}

}  // namespace
}  // namespace feltwire::energy_tank_test
