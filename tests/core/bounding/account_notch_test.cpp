// A tick is late while a hand rests and the account limits its force. The force must stay constant.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/bounding/device_account.hpp"
#include "core/bounding/hold_time_margin.hpp"
#include "tests/core/bounding/account_samples.hpp"

namespace feltwire::account_notch_test {
namespace {

using namespace test;

constexpr double kPeriod = kSamplePeriod;

/// The largest relative change of the force from one sample to the next.
struct Notch {
  double deepest = 0.0, highest = 0.0;
  double force = 0.0;  // [N] before the late tick
};

/// A resting hand commands `most`, and the account has `energy` [J]. A single tick is `late` [T].
/// The next tick comes at its deadline, or a period later.
Notch stand(const AccountConfig& config, const Command& most, double energy, double late,
            bool deadlines, bool knows_hand) {
  PortAccount account(config);
  HoldTimeMargin reserve(kPeriod);
  const auto tick = [&](double hold) {
    reserve.saw(hold, true);
    const Command given =
        account.step(sample(Vec3::Zero(), most, hold),
                     knows_hand ? reserve.hold_time() : reserve.hold_time_of_any_hand());
    return length(given.force()) + length(given.torque);
  };
  for (int n = 0; n < 3; ++n) account.step(sample(Vec3::Zero(), {}));
  account.credit(energy);
  Notch notch;
  for (int n = 0; n < 400; ++n) notch.force = tick(kPeriod);
  double before = notch.force;
  const auto compare = [&](double now) {
    notch.deepest = std::max(notch.deepest, 1.0 - now / before);
    notch.highest = std::max(notch.highest, now / before - 1.0);
    before = now;
  };
  compare(tick((1.0 + late) * kPeriod));
  if (deadlines) compare(tick((1.0 - late) * kPeriod));
  for (int n = 0; n < 4000; ++n) compare(tick(kPeriod));
  EXPECT_NEAR(before, notch.force, 1e-3 * notch.force) << "and it is forgotten";
  return notch;
}

std::vector<DeviceSpec> known_devices() {
  std::vector<DeviceSpec> devices;
  for (const DeviceSpec& spec : builtin_devices())
    if (spec.least_mass > 0.0) devices.push_back(spec);
  DeviceSpec other = builtin_device("phantom_premium_1.5");
  other.least_mass = 0.075;
  devices.push_back(other);
  return devices;
}

// [N] forces that the energy covers
constexpr double kForces[] = {0.1, 0.2, 0.45, 1.0, 2.0, 4.0, 8.0};

/// The command and the covered command. Both have the same direction.
struct Commands {
  Command most, paid;
};

/// Without a delay of the device the account has no reserve for small forces and diagonals.
constexpr double kWithoutReserve = 0.1;

/// `share`: of the force that may be missing in the deepest sample.
void expect_no_notch(const DeviceSpec& spec, const Commands& commands, bool knows_hand,
                     double share = 0.05) {
  const AccountConfig config =
      knows_hand ? account_config(spec, kPeriod) : any_hand_account(spec, kPeriod);
  const double wanted = length(commands.paid.force()) + length(commands.paid.torque);
  for (const double late : {0.1, 0.3, 0.5})
    for (const bool deadlines : {true, false}) {
      const Notch notch = stand(config, commands.most, need_at_rest(config, commands.paid), late,
                                deadlines, knows_hand);
      // The reserve of the account may reduce a small force only a little.
      EXPECT_GT(notch.force, 0.94 * wanted) << spec.name << ' ' << spec.actuation.late_ticks;
      EXPECT_LT(notch.force, (1.0 + 1e-9) * wanted)
          << spec.name << ' ' << spec.actuation.late_ticks;
      EXPECT_LT(notch.deepest, share) << spec.name << ' ' << spec.actuation.late_ticks << " late "
                                      << late << ' ' << deadlines << " force " << notch.force;
      EXPECT_LT(notch.highest, share) << spec.name << ' ' << spec.actuation.late_ticks << " late "
                                      << late << ' ' << deadlines << " force " << notch.force;
    }
}

/// On a device that applies forces late, the reachable displacement affects all forces that the
/// device got. Small forces need most of their energy for the reachable displacement of a strong
/// hand.
TEST(AccountNotch, AHandThatStandsStillFeelsNoTickThatIsLate) {
  for (DeviceSpec spec : known_devices())
    for (spec.actuation.late_ticks = 0; spec.actuation.late_ticks <= 2; ++spec.actuation.late_ticks)
      for (const Vec3& along : {Vec3(0, 0, 1), Vec3(0, -0.6, 0.8), Vec3(0.6, -0.64, 0.48)})
        for (const double force : kForces)
          if (force < spec.max_force)
            expect_no_notch(spec, {{.elastic = spec.max_force * along}, {.elastic = force * along}},
                            true,
                            spec.actuation.late_ticks > 0 || (force >= 1.0 && along.z() == 1.0)
                                ? 0.05
                                : kWithoutReserve);
}

TEST(AccountNotch, NorDoesOneThatATorqueTurns) {
  for (DeviceSpec spec : known_devices()) {
    if (spec.rotation_actuated == 0) continue;
    for (spec.actuation.late_ticks = 0; spec.actuation.late_ticks <= 2; ++spec.actuation.late_ticks)
      for (const double share : {0.9, 0.3, 0.1, 0.03})
        expect_no_notch(spec,
                        {{.torque = Vec3(0, spec.max_torque, 0)},
                         {.torque = Vec3(0, share * spec.max_torque, 0)}},
                        true);
  }
}

/// The account has no data about this hand.
TEST(AccountNotch, NorDoesAnyOtherHand) {
  for (DeviceSpec spec : builtin_devices())
    for (spec.actuation.late_ticks = 0; spec.actuation.late_ticks <= 2; ++spec.actuation.late_ticks)
      for (const double force : kForces)
        if (force < spec.max_force)
          expect_no_notch(spec,
                          {{.elastic = Vec3(0, 0, spec.max_force)}, {.elastic = Vec3(0, 0, force)}},
                          false);
}

/// On some devices a shorter reachable displacement has no noticeable effect. On such devices the
/// account must have no reserve.
TEST(AccountNotch, OnlyWhatIsNeededIsKept) {
  for (const char* name : {"simulated", "impulse_engine_2000"}) {
    const AccountConfig config = account_config(builtin_device(name), kPeriod);
    const Command paid{.elastic = Vec3(0, 0, 0.2)};
    const Command most{.elastic = Vec3(0, 0, 8)};
    const double energy = need_at_rest(config, paid);
    EXPECT_NEAR(stand(config, most, energy, 0.3, true, true).force, 0.2, 1e-9) << name;
  }
}

}  // namespace
}  // namespace feltwire::account_notch_test
