// Compares the virtual coupling with closed forms.

#include <gmock/gmock.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "tests/core/support.hpp"

namespace feltwire::virtual_coupling_test {
namespace {

using ::testing::HasSubstr;

constexpr double kPeriod = test::kModePeriod;

BoundingConfig coupling(const CouplingConfig& c) {
  BoundingConfig config = test::config("virtual_coupling");
  config.coupling = c;
  return config;
}
BoundingStep step(double dx, double scene = 0.0) {
  BoundingStep s;
  s.displacement.x() = dx;
  s.hold_time = kPeriod;
  s.command.elastic.x() = scene;
  return s;
}

TEST(VirtualCoupling, OneSampleByHand) {
  // v = (h k dx + b_c dx) / (m + h b_c + h^2 k) = 3e-4 / 0.0503;  s = dx - h v;  f = -(k + b_c/h)
  // s.
  Bounding bounding(coupling({100.0, 0.2, 0.05}));
  const double v = 3e-4 / 0.0503;
  EXPECT_NEAR(bounding.step(step(1e-3)).rendered.force().x(), -300.0 * (1e-3 - 1e-3 * v), 1e-15);
  EXPECT_NEAR(bounding.probe(Vec3::Zero(), Vec3::Zero()).offset.x(), 1e-3 * v - 1e-3, 1e-18);
  EXPECT_NEAR(bounding.probe(Vec3(2e-3, 0, 0), Vec3::Zero()).offset.x(), 1e-3 * v - 3e-3, 1e-18);
}

TEST(VirtualCoupling, TheSecondSampleByHand) {
  // With b_c = 0 and m = h^2 k, each sample halves the distance: v = (m v + h k (s + dx)) / (2 h^2
  // k).
  const double k = 100.0;
  Bounding bounding(coupling({k, 0.0, k * kPeriod * kPeriod}));
  EXPECT_NEAR(bounding.step(step(8e-3)).rendered.force().x(), -k * 4e-3, 1e-15);
  // v h = (4e-3 + 4e-3) / 2 = 4e-3: the tool reaches the device.
  EXPECT_NEAR(bounding.step(step(0.0)).rendered.force().x(), 0.0, 1e-15);
  // The tool passes the device.
  EXPECT_NEAR(bounding.step(step(0.0)).rendered.force().x(), k * 2e-3, 1e-15);
}

TEST(VirtualCoupling, AStillHandHoldsTheScenesForceAtStretchFOverK) {
  Bounding bounding(coupling({250.0, {}, 0.05}));
  double force = 0.0;
  for (int n = 0; n < 20000; ++n) force = bounding.step(step(0.0, 3.0)).rendered.force().x();
  EXPECT_NEAR(force, 3.0, 1e-9);
  EXPECT_NEAR(bounding.probe(Vec3::Zero(), Vec3::Zero()).offset.x(), 3.0 / 250.0, 1e-12);
}

TEST(VirtualCoupling, WhatIsNotGivenIsTheStiffestThatIsPassive) {
  // k = 2 b/T = 1000 leaves no damping. An immovable tool answers k dx.
  Bounding bounding(coupling({{}, {}, 1e12}));
  EXPECT_NEAR(bounding.step(step(1e-3)).rendered.force().x(), -1000.0 * 1e-3, 1e-12);
  // With b_c given, k = 2 (b - b_c) / T = 600 remains: (k + b_c / h) dx.
  Bounding damped(coupling({{}, 0.2, 1e12}));
  EXPECT_NEAR(damped.step(step(1e-3)).rendered.force().x(), -(600.0 + 200.0) * 1e-3, 1e-12);
  // With k given, b_c = b - kT/2 = 0.25 remains: (k + b_c / h) dx.
  Bounding softer(coupling({500.0, {}, 1e12}));
  EXPECT_NEAR(softer.step(step(1e-3)).rendered.force().x(), -(500.0 + 250.0) * 1e-3, 1e-12);
  EXPECT_NEAR(softer.step(step(0.0)).rendered.force().x(), -500.0 * 1e-3, 1e-12);
}

TEST(VirtualCoupling, ADroppedForceBringsTheToolToTheDevice) {
  Bounding bounding(coupling({}));
  bounding.step(step(1e-3));
  bounding.set_held({});
  EXPECT_EQ(bounding.probe(Vec3::Zero(), Vec3::Zero()).offset, Vec3::Zero());
  EXPECT_EQ(bounding.step(step(0.0)).rendered.force(), Vec3::Zero());
}

TEST(VirtualCoupling, TurnsTheSameWay) {
  BoundingConfig c = coupling({});
  c.coupling_rotation = {0.5, 0.0, 0.5 * kPeriod * kPeriod};
  Bounding bounding(c);
  BoundingStep s;
  s.hold_time = kPeriod;
  s.rotation = Vec3(0, 0, 8e-3);
  EXPECT_NEAR(bounding.step(s).rendered.torque.z(), -0.5 * 4e-3, 1e-15);
  EXPECT_NEAR(bounding.probe(Vec3::Zero(), Vec3::Zero()).rotation.z(), -4e-3, 1e-18);
}

TEST(VirtualCoupling, WhatIsNotPassiveIsRefusedWithTheRemedy) {
  const auto reason = [](const CouplingConfig& c) -> std::string {
    try {
      Bounding bounding(coupling(c));
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(reason({1000.0, 0.0, 0.05}), "accepted");  // k = 2 b / T
  EXPECT_EQ(reason({0.0, 0.5, 0.05}), "accepted");
  EXPECT_THAT(reason({1000.1, {}, 0.05}), HasSubstr("lower its stiffness"));
  EXPECT_THAT(reason({500.0, 0.2501, 0.05}), HasSubstr("0.5001"));
  EXPECT_THAT(reason({-1.0, {}, 0.05}), HasSubstr("stiffness"));
  EXPECT_THAT(reason({{}, -0.1, 0.05}), HasSubstr("damping"));
  for (const double mass : {0.0, -1.0, std::nan("")})
    EXPECT_THAT(reason({{}, {}, mass}), HasSubstr("mass"));
}

}  // namespace
}  // namespace feltwire::virtual_coupling_test
