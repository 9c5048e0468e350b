// Tests the passive methods. The hand never gets more energy than the device dissipated, for all
// hands, scenes and networks.

#include <cmath>

#include "tests/core/play.hpp"

namespace feltwire::properties_test {
namespace {

using namespace test;

/// RapidCheck can shrink and print an index, so an index selects the bound.
constexpr int kPassiveLaws = 6;
BoundingConfig passive_law(int which) {
  BoundingConfig c = config("contact_frame");
  c.projection = which % 2 ? Projection::cone : Projection::joint;
  c.storage = which / 2 % 2 ? Storage::elastic : Storage::minimal;
  if (which == 4) c.mode = "energy_tank";
  if (which == 5) c.mode = "per_axis";
  return c;
}
std::vector<BoundingConfig> passive_laws() {
  std::vector<BoundingConfig> all;
  all.reserve(kPassiveLaws);
  for (int i = 0; i < kPassiveLaws; ++i) all.push_back(passive_law(i));
  return all;
}
/// The method with more assumed damping than the device has.
BoundingConfig boasting(BoundingConfig c, double factor) {
  c.damping = factor * c.damping.least();
  c.rotational_damping = factor * c.rotational_damping.least();
  return c;
}
template <class Real>
void never_more_than_burned(const Script& script, const std::vector<BoundingConfig>& laws,
                            const Port& port = {}, double condition = 1.0) {
  Margin margin{port};
  play<Real>(script, laws, port, [&](const Played<Real>& p, const auto&) {
    margin.account(p);
    RC_ASSERT(margin.kept<Real>(condition));
  });
}

RC_GTEST_PROP(Property, DeliveredIsNeverMoreThanBurned, ()) {
  const int which = *rc::gen::inRange(0, kPassiveLaws);
  const Script script = *scripts({.reduces = true});
  never_more_than_burned<double>(script, {passive_law(which)});
}

RC_GTEST_PROP(Property, DeliveredIsNeverMoreThanBurnedInFloat, ()) {
  const int which = *rc::gen::inRange(0, kPassiveLaws);
  const Script script = *scripts({.reduces = true});
  never_more_than_burned<float>(script, {passive_law(which)});
}

RC_GTEST_PROP(Property, SaturationChangesNothing, ()) {
  BoundingConfig c = passive_law(*rc::gen::inRange(0, kPassiveLaws));
  c.max_force = 0.3;
  c.max_torque = 1e-3;
  never_more_than_burned<double>(*scripts({.reduces = true}), {c});
}

// These methods bound only the magnitude. The device may even rotate the held force.
RC_GTEST_PROP(Property, BendingChangesNothing, ()) {
  const int which = *rc::gen::inRange(0, kPassiveLaws - 1);  // all but per_axis
  never_more_than_burned<double>(*scripts({.reduces = true, .bends = true}), {passive_law(which)});
}

RC_GTEST_PROP(Property, NoChangeOfTheLawAtRunTimeGivesEnergy, ()) {
  const Script script = *scripts({.reduces = true, .laws = kPassiveLaws});
  never_more_than_burned<double>(script, passive_laws());
  never_more_than_burned<float>(script, passive_laws());
}

// Eq. (2) must hold on each axis at the real port.
template <class Real>
void every_axis_pays_for_itself(const Script& script, const std::vector<BoundingConfig>& laws,
                                const Vec3& damping, const Vec3& rotational) {
  std::array<Sum, 6> axes;
  const Port port{Damping(damping), Damping(rotational)};
  play<Real>(script, laws, port, [&](const Played<Real>& p, const auto&) {
    const double time = std::max(p.hold_time, kModePeriod);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<int>(i);
      axes[i].add(damping[k] / time * p.displacement[k] * p.displacement[k]);
      axes[i].add(-p.before.force()[k] * p.displacement[k]);
      axes[i + 3].add(rotational[k] / time * p.rotation[k] * p.rotation[k]);
      axes[i + 3].add(-p.before.torque[k] * p.rotation[k]);
    }
    // The parts of a force and their sum have the rounding error of the longest part.
    for (const Sum& s : axes) RC_ASSERT(s.value >= -s.rounding<Real>());
  });
}

RC_GTEST_PROP(Property, PerAxisEveryAxisPaysForItself, ()) {
  BoundingConfig c = config("per_axis");
  const Vec3 damping(0.5, 0.1, 2.0), rotational(1e-3, 5e-3, 2e-4);
  c.damping = damping;
  c.rotational_damping = rotational;
  const Script script = *scripts({.reduces = true, .laws = 2});
  every_axis_pays_for_itself<double>(script, {c, c}, damping, rotational);
  every_axis_pays_for_itself<float>(script, {c, c}, damping, rotational);
}

// Faults overdraw the port, and no method can prevent this. The method must render a force only if
// the dissipated energy covers the worst movement of the hand.
template <class Real>
void no_force_on_credit(const Script& script, const BoundingConfig& law, const Port& port,
                        double condition = 1.0) {
  Margin margin{port};
  play<Real>(script, {law}, port, [&](const Played<Real>& p, const auto&) {
    margin.account(p);
    const auto at_stake = [](const Vec3& f, const Damping& damping) {
      return 0.5 * f.dot(greediest(f, kModePeriod, damping));
    };
    const Command given = p.out.rendered.template cast<double>();
    const double force = at_stake(given.force(), port.damping);
    const double torque = at_stake(given.torque, port.rotational_damping);
    if (force > 0.0)
      RC_ASSERT(margin.translation.value - force >= -margin.translation.rounding<Real>(condition));
    if (torque > 0.0)
      RC_ASSERT(margin.rotation.value - torque >= -margin.rotation.rounding<Real>(condition));
  });
}

RC_GTEST_PROP(Property, FaultsAreRepaidBeforeAnyForce, ()) {
  const int which = *rc::gen::inRange(0, kPassiveLaws - 1);  // per_axis has no debts.
  const Script script =
      *scripts({.longest_hold = 5.0, .reduces = true, .skips = true, .loses = true});
  no_force_on_credit<double>(script, passive_law(which), {});
  no_force_on_credit<float>(script, passive_law(which), {});
}

// --- Mutants: with c = 2.1 b/T instead of 2 b/T, the hands above must gain energy. This shows that
// the tests above can fail.

/// Returns true if one of 50 random scripts breaks the guarantee.
bool some_hand_wins(const std::vector<BoundingConfig>& laws, const ScriptOptions& options) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Script script = scripts(options)(rc::Random(seed), 100).value();
    Margin margin;
    bool won = false;
    play(script, laws, {}, [&](const Played<double>& p, const auto&) {
      margin.account(p);
      won = won || !margin.kept<double>();
    });
    if (won) return true;
  }
  return false;
}

TEST(Mutant, FivePercentTooMuchDampingLoses) {
  for (int which = 0; which < kPassiveLaws - 1; ++which) {  // The next test covers per_axis.
    EXPECT_TRUE(some_hand_wins({boasting(passive_law(which), 1.05)}, {.reduces = true})) << which;
    EXPECT_FALSE(some_hand_wins({passive_law(which)}, {.reduces = true})) << which;
  }
}

// Per axis, the storage F^2 T / (2 b) is twice the energy of one sample. A hand needs many samples
// to empty the storage. The hand presses in steps so small that they dissipate nothing. The hand
// then retreats in steps of 6 % of F T / b while the scene commands the maximum.
double taken_from_per_axis(double factor) {
  BoundingConfig c = config("per_axis");
  c.c1 = c.c2 = factor * 0.5 / kModePeriod;
  Script script;
  const Command all{Vec3(0, 0, 1e3), Vec3::Zero(), Vec3::Zero()};
  for (int n = 0; n < 20000; ++n)
    script.ticks.push_back({.displacement = Vec3(0, 0, -1e-7), .command = all});
  for (int n = 0; n < 200; ++n)
    script.ticks.push_back({.hand = Hand::takes, .share = 0.12, .command = all});
  Margin margin;
  play(script, {c}, {}, [&](const Played<double>& p, const auto&) { margin.account(p); });
  return -margin.translation.value;
}

TEST(Mutant, PerAxisConstantsFivePercentTooLargeLose) {
  EXPECT_GT(taken_from_per_axis(1.05), 1e-8);
  EXPECT_LT(taken_from_per_axis(1.0), 0.0);
}

TEST(Mutant, LawsThatPromiseNothingLose) {
  for (const std::string_view mode : {"none", "total_energy"})
    EXPECT_TRUE(some_hand_wins({config(mode)}, {})) << mode;
}

}  // namespace
}  // namespace feltwire::properties_test
