// virtual_coupling: the delivered energy is at most the dissipated energy plus the scene's work on
// the tool. This holds for every hand and command. The test uses the limit b = k T / 2 + b_c.

#include <cmath>
#include <stdexcept>

#include "tests/core/play.hpp"

namespace feltwire::coupling_properties_test {
namespace {

using namespace test;

/// Returns a coupling with `share` of the largest stiffness 2 b / T, and with all remaining
/// damping: b = k T / 2 + b_c.
BoundingConfig coupling(double share, double mass, double factor = 1.0) {
  BoundingConfig c = config("virtual_coupling", factor * 0.5);
  c.rotational_damping = factor * 1e-3;
  c.coupling = {share * factor * 2.0 * 0.5 / kModePeriod, {}, mass};
  c.coupling_rotation = {share * factor * 2.0 * 1e-3 / kModePeriod, {}, 1e-3 * mass};
  return c;
}

/// Energy margin at the port, including the work of the scene on the tool.
template <class Real>
struct ToolMargin {
  Margin margin;
  Vec3 tool = Vec3::Zero(), orientation = Vec3::Zero();  // displacement since the common start
  Vec3 device = Vec3::Zero(), turned = Vec3::Zero();

  void account(const Played<Real>& p, const BasicBounding<Real>& bounding) {
    margin.account(p);
    device += p.displacement;
    turned += p.rotation;
    const auto probe = bounding.probe(Vector3<Real>::Zero(), Vector3<Real>::Zero());
    const Vec3 now = device + probe.offset.template cast<double>();
    const Vec3 now_turned = turned + probe.rotation.template cast<double>();
    const Command scene = p.told.command.template cast<double>();
    margin.translation.add(scene.force(), now - tool);
    margin.rotation.add(scene.torque, now_turned - orientation);
    // The tool's position is a difference and has the rounding errors of the device's position.
    slack += (scene.force().norm() * device.norm() + scene.torque.norm() * turned.norm()) * 64.0 *
             std::numeric_limits<Real>::epsilon();
    tool = now;
    orientation = now_turned;
  }
  bool kept() const {
    return margin.translation.value >= -margin.translation.template rounding<Real>() - slack &&
           margin.rotation.value >= -margin.rotation.template rounding<Real>() - slack;
  }
  double slack = 0.0;
};

template <class Real>
bool holds(const Script& script, const BoundingConfig& law) {
  ToolMargin<Real> sum;
  bool kept = true;
  play<Real>(script, {law}, {}, [&](const Played<Real>& p, const auto& bounding) {
    sum.account(p, bounding);
    kept = kept && sum.kept();
  });
  return kept;
}

RC_GTEST_PROP(Property, CouplingGivesNoMoreThanBurnedAndTheScenesWork, ()) {
  const double share = 0.01 * *rc::gen::inRange(0, 101);
  const double mass = std::pow(10.0, -0.1 * *rc::gen::inRange(0, 40));  // 0.1 g to 1 kg
  const Script script = *scripts({});
  RC_ASSERT(holds<double>(script, coupling(share, mass)));
}

RC_GTEST_PROP(Property, CouplingInFloat, ()) {
  const double share = 0.01 * *rc::gen::inRange(0, 100);
  const double mass = std::pow(10.0, -0.1 * *rc::gen::inRange(0, 30));
  const Script script = *scripts({});
  RC_ASSERT(holds<float>(script, coupling(share, mass)));
}

/// The worst case of a sampled spring: an immovable tool and a hand that trembles.
Script tremble() {
  Script script;
  for (int n = 0; n < 200; ++n) script.ticks.push_back({.hand = Hand::trembles});
  return script;
}

TEST(Mutant, ACouplingFivePercentTooStrongLosesAtEveryStiffness) {
  for (const double share : {0.0, 0.3, 1.0}) {
    EXPECT_TRUE(holds<double>(tremble(), coupling(share, 1e3))) << share;
    EXPECT_FALSE(holds<double>(tremble(), coupling(share, 1e3, 1.05))) << share;
  }
}

RC_GTEST_PROP(Property, ACouplingBeyondColgatesConditionCanNotBeMade, ()) {
  const double share = 0.01 * *rc::gen::inRange(0, 101);
  const double beyond = 1.0 + std::pow(10.0, -*rc::gen::inRange(0, 10));
  BoundingConfig c = coupling(share, 0.05);
  const double left = 0.5 * (1.0 - share);
  Bounding(BoundingConfig(c));
  c.coupling.damping = left * beyond + (left > 0.0 ? 0.0 : 0.5 * (beyond - 1.0));
  RC_ASSERT_THROWS_AS(Bounding(BoundingConfig(c)), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::coupling_properties_test
