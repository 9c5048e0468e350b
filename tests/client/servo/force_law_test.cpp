// Tests the fourth stage of a tick alone: it turns a command into the force for the hand.

#include "client/servo/force_law.hpp"

#include <gtest/gtest.h>

#include "core/device/device_file.hpp"

namespace feltwire::force_law_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

SessionParameters session(std::string_view mode) {
  SessionParameters p;
  p.mode = mode;
  return p;
}

struct Law {
  explicit Law(std::string_view mode, const DeviceSpec& device = builtin_device("simulated"),
               const ServoOptions& options = {})
      : spec(device), law(spec, session(mode), options) {}

  /// Runs a tick: the hand moved by `way`, and the scene commands `asked`. Returns the force.
  Command tick(const Vec3& way, const Command& asked, bool known = true, double share = 1.0) {
    BoundingStep step;
    step.hold_time = kPeriod;
    step.displacement = way;
    step.command = asked;
    trail = {};
    law.moved({}, {.read = true, .known = known, .displacement = way}, kPeriod, statistics.device);
    law.saw(step, known);
    const Command given = law.apply(
        step, {.wanted = asked, .share = share, .original = true, .movement_known = known}, trail,
        statistics.law);
    law.hold(given, given);
    return given;
  }

  DeviceSpec spec;
  ForceLaw law;
  ForceTrail trail;
  ServoStatistics statistics;
};

const Command kPush{.elastic = Vec3(0, 0, 2)};

TEST(ForceLaw, WithoutABoundTheCommandPasses) {
  Law none("none");
  EXPECT_EQ(none.tick({0, 0, -1e-4}, kPush), kPush);
  EXPECT_EQ(none.law.held(), kPush);
  EXPECT_TRUE(none.law.holds());
  EXPECT_FALSE(none.law.law().account);
}

/// The force pushes the hand out repeatedly. The hand must never get more energy than the device
/// dissipated.
TEST(ForceLaw, GivesNoMoreThanWasBurned) {
  for (const char* mode : {"contact_frame", "per_axis", "total_energy", "shaped"}) {
    Law bound(mode);
    for (int n = 0; n < 2000; ++n) {
      bound.tick({0, 0, n % 40 < 20 ? -2e-5 : 2e-5}, kPush);
      ASSERT_GE(bound.law.port().margin(), -1e-12) << mode << ' ' << n;
    }
    EXPECT_EQ(bound.law.owed(), 0.0) << mode;
    EXPECT_FALSE(bound.law.overdraft()) << mode;
  }
}

TEST(ForceLaw, AShareOfZeroLeavesNothingWhateverTheBoundKeeps) {
  Law bound("per_axis");
  for (int n = 0; n < 50; ++n) bound.tick({0, 0, -1e-4}, kPush);
  ASSERT_GT(bound.law.held().force().norm(), 0.01);
  EXPECT_TRUE(bound.tick(Vec3::Zero(), {}, true, 0.0).force().isZero(0.0));
}

/// The device reports a held force below the command. The account must use the held force.
TEST(ForceLaw, AccountsForWhatTheDeviceHeld) {
  Law none("none");
  none.tick(Vec3::Zero(), kPush);
  DeviceReading reading;
  reading.held = Command{.elastic = Vec3(0, 0, 0.5)};
  none.law.moved(reading, {.read = true, .known = true, .displacement = Vec3(0, 0, 1e-3)}, kPeriod,
                 none.statistics.device);
  EXPECT_EQ(none.law.held(), *reading.held);
  EXPECT_NEAR(none.law.port().delivered().total(), 0.5e-3, 1e-15);
  EXPECT_EQ(none.statistics.device.forces_corrected, 1u);
}

TEST(ForceLaw, ALateDeviceHoldsWhatWasGivenBefore) {
  DeviceSpec spec = builtin_device("simulated");
  spec.actuation.late_ticks = 1;
  Law late("none", spec);
  late.tick(Vec3::Zero(), kPush);
  EXPECT_TRUE(late.law.held().force().isZero(0.0)) << "it comes one tick later";
  EXPECT_TRUE(late.law.holds());
  late.tick(Vec3::Zero(), {});
  EXPECT_EQ(late.law.held().force(), kPush.force());
  late.tick(Vec3::Zero(), {});
  EXPECT_FALSE(late.law.holds());
}

/// A change of the method keeps the debt, even if the method in between has no account.
TEST(ForceLaw, ADebtOutlivesItsLaw) {
  ServoOptions options;
  options.owed = 1e-3;
  const DeviceSpec spec = builtin_device("simulated");
  Law owes("contact_frame", spec, options);
  EXPECT_EQ(owes.law.owed(), 1e-3);
  ServoLaw none(spec, session("none"), options), again(spec, session("contact_frame"), {});
  owes.law.adopt(none);
  EXPECT_TRUE(owes.law.changes());
  owes.law.exchange();
  EXPECT_FALSE(owes.law.changes());
  EXPECT_EQ(owes.law.owed(), 1e-3);
  EXPECT_EQ(none.parameters.mode, "contact_frame") << "it received the old law";
  owes.law.adopt(again);
  owes.law.exchange();
  EXPECT_EQ(owes.law.owed(), 1e-3);
  EXPECT_TRUE(owes.tick(Vec3::Zero(), kPush).force().isZero(0.0)) << "nothing is left to pay";
}

}  // namespace
}  // namespace feltwire::force_law_test
