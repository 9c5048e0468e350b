// Checks passivity observers and controllers on samples with manual calculations. F has the paper's
// sign.

#include "core/bounding/passivity_control.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/support.hpp"

namespace feltwire::passivity_control_test {
namespace {

constexpr double kPeriod = test::kModePeriod;

Bounding controller(std::string_view mode, PassivityReference reference) {
  BoundingConfig c = test::config(mode);
  c.reference = reference;
  return Bounding(c);
}
/// Applies F_e = `force` along x after the device moved by dx. Returns F.
double x_step(Bounding& bounding, double dx, double force) {
  BoundingStep s;
  s.displacement.x() = dx;
  s.hold_time = kPeriod;
  s.command.elastic.x() = -force;
  return -bounding.step(s).rendered.force().x();
}

TEST(PassivityControl, SeriesDissipatesWhatIsMissingAtOnce) {
  Bounding b = controller("passivity_control", PassivityReference::zero);
  EXPECT_DOUBLE_EQ(x_step(b, 1e-3, 2.0), 2.0);      // W = 2 mJ
  EXPECT_NEAR(x_step(b, -1e-3, 3.0), 2.0, 1e-12);   // 3 mJ delivered, 1 mJ missing: F = 3 - 1
  EXPECT_NEAR(x_step(b, 0.5e-3, 1.0), 1.0, 1e-12);  // W = 0 + 0.5 mJ
  EXPECT_NEAR(x_step(b, -1e-3, 0.5), 0.5, 1e-12);   // uses the complete energy
  EXPECT_NEAR(x_step(b, -2e-3, 0.25), 0.0, 1e-12);  // No energy remains.
  EXPECT_NEAR(x_step(b, 0.0, 7.0), 7.0, 1e-12);     // Without movement the damper has no effect.
}

TEST(PassivityControl, OneAxisDoesNotPayForAnother) {
  Bounding b = controller("passivity_control", PassivityReference::zero);
  BoundingStep s;
  s.displacement = Vec3(1e-3, 1e-3, 0);
  s.hold_time = kPeriod;
  s.command.elastic = Vec3(-5.0, 1.0, 0);
  EXPECT_NEAR((b.step(s).rendered.force() - Vec3(-5.0, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(PassivityControl, TheReferenceOfASpringIsItsEnergy) {
  // The energy of the zero-order hold is excluded (0). The complete reference energy is therefore
  // missing.
  PassivityObserver<double> observer(PassivityReference::following);
  const double k = 700.0;
  test::Random random(5);
  double x = 0.0, force = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const double dx = random.decades(-7.0, -3.0);
    const double now = k * (x + dx);
    const double missing = observer.observe(now * dx, force * dx, 0.0);
    x += dx;
    force = now;
    ASSERT_NEAR(missing, 0.5 * k * x * x, 1e-12);
  }
}

TEST(PassivityControl, FollowingRepaysWhatTheHoldGaveWhereTheHandMovesOn) {
  // A spring of 1 kN/m moves 1 mm in, 1 mm more, and out again. E = 0.5, 2, 0.5, 0 mJ.
  BoundingConfig c = test::config("passivity_control", 2.0);
  c.reference = PassivityReference::following;
  Bounding b(c);
  EXPECT_NEAR(x_step(b, 1e-3, 1.0), 1.5, 1e-12);    // W = 0:          1 + 0.5 mJ / 1 mm
  EXPECT_NEAR(x_step(b, 1e-3, 2.0), 2.5, 1e-12);    // W = 1.5 mJ:     2 + 0.5
  EXPECT_NEAR(x_step(b, -1e-3, 1.0), -0.5, 1e-12);  // W = -1 mJ:      1 - 1.5
  EXPECT_NEAR(x_step(b, -1e-3, 0.0), -0.5, 1e-12);  // W = -0.5 mJ:    0 - 0.5
}

TEST(PassivityControl, TheDamperOfFollowingIsAtMostTheDevicesOwn) {
  // This is the movement above with b = 0.5: the damper gives at most 500 N/m over 1 mm.
  Bounding b = controller("passivity_control", PassivityReference::following);
  EXPECT_NEAR(x_step(b, 1e-3, 1.0), 1.5, 1e-12);
  EXPECT_NEAR(x_step(b, 1e-3, 2.0), 2.5, 1e-12);
  EXPECT_NEAR(x_step(b, -1e-3, 1.0), 0.5, 1e-12);  // 1.5 mJ are missing.
}

TEST(PassivityControl, WhatTheDeviceCannotHoldIsNotMissing) {
  // A spring of 1 kN/m on a device of 1 N. Beyond 1 mm the reference force is constant.
  BoundingConfig c = test::config("passivity_control", 2.0);
  c.reference = PassivityReference::following;
  c.max_force = 1.0;
  Bounding b(c);
  x_step(b, 0.0, 0.0);
  for (int n = 1; n <= 10; ++n) x_step(b, 1e-3, 1.0 * n);
  // On the way in, the device held 9 mJ, and the reference of the flat spring is 9.5 mJ. On the way
  // out, only this difference and the energy of the reversal are missing.
  EXPECT_NEAR(x_step(b, -1e-3, 9.0), 1.0, 1e-12);
  EXPECT_NEAR(x_step(b, -1e-3, 8.0), 1.0, 1e-12);
}

TEST(PassivityControl, DirectionalSharesByWhatEachExchanged) {
  Bounding b = controller("passivity_control_directional", PassivityReference::zero);
  BoundingStep s;
  s.hold_time = kPeriod;
  // In: 4 mJ and 1 mJ.
  s.displacement = Vec3(-1e-3, 0, 0);
  s.rotation = Vec3(0, 0, -0.01);
  s.command = {Vec3(4, 0, 0), Vec3::Zero(), Vec3(0, 0, 0.1)};
  Command r = b.step(s).rendered;
  EXPECT_NEAR(r.force().x(), 4.0, 1e-12);
  EXPECT_NEAR(r.torque.z(), 0.1, 1e-12);
  // Out: 6 mJ and 2 mJ. With 3 mJ missing, the force contributes 3/4 and the torque 1/4.
  s.displacement = Vec3(2e-3, 0, 0);
  s.rotation = Vec3(0, 0, 0.02);
  s.command = {Vec3(3, 0, 0), Vec3::Zero(), Vec3(0, 0, 0.1)};
  r = b.step(s).rendered;
  EXPECT_NEAR(r.force().x(), 3.0 - 0.75 * 3e-3 / 2e-3, 1e-12);
  EXPECT_NEAR(r.torque.z(), 0.1 - 0.25 * 3e-3 / 0.02, 1e-12);
}

TEST(PassivityControl, DirectionalKeepsTheLineOfTheForce) {
  Bounding b = controller("passivity_control_directional", PassivityReference::zero);
  BoundingStep s;
  s.hold_time = kPeriod;
  s.displacement = Vec3(1e-3, 0, 0);
  // 3 mJ delivered; u.dx = 0.6 mm, so the force along u falls by 5 N
  s.command.elastic = Vec3(3, 4, 0);
  EXPECT_NEAR(b.step(s).rendered.force().norm(), 0.0, 1e-12);
}

TEST(PassivityControl, ParallelMovesTheProbeInsteadOfTheForce) {
  Bounding b = controller("passivity_control_parallel", PassivityReference::zero);
  const auto offset = [&] { return b.probe(Vec3::Zero(), Vec3::Zero()).offset.x(); };
  EXPECT_DOUBLE_EQ(x_step(b, 1e-3, 2.0), 2.0);  // W = 2 mJ
  EXPECT_EQ(offset(), 0.0);
  EXPECT_DOUBLE_EQ(x_step(b, -1e-3, 4.0), 4.0);  // 2 mJ missing: W / F = 0.5 mm
  EXPECT_NEAR(offset(), -0.5e-3, 1e-15);
  EXPECT_DOUBLE_EQ(x_step(b, -0.2e-3, 5.0), 5.0);  // 1 mJ missing, 0.2 mm: the complete movement
  EXPECT_NEAR(offset(), -0.7e-3, 1e-15);
  EXPECT_EQ(x_step(b, -1e-3, 0.0), 0.0);  // out of contact
  EXPECT_EQ(offset(), 0.0);
}

}  // namespace
}  // namespace feltwire::passivity_control_test
