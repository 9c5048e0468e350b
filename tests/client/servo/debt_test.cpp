// Debts of the energy account. The account is in debt after the device delivered more energy than
// its damping dissipated, for example in a stall. The device must dissipate the missing energy, or
// the force must end. A new bounding method, a lost session or a new run must keep the debt.

#include <gtest/gtest.h>

#include <deque>
#include <optional>

#include "client/hands/simulated_device.hpp"
#include "client/run/debts.hpp"
#include "client/servo/stall_detector.hpp"
#include "server/scene/session.hpp"
#include "sim/hands/eight_hands.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::debt_test {
namespace {

using namespace testing::servo;
using test::Random;

constexpr std::array kLaws = {"shaped", "contact_frame", "midpoint", "credited", "energy_tank"};

SessionParameters with_model(std::string_view mode) {
  SessionParameters p = parameters(mode);
  p.local_model = true;
  return p;
}

/// Simulates a hand on a floor and its server, and measures the energy at the true port.
struct Hand {
  explicit Hand(std::string_view mode, double stiffness = 5e3, const ServoOptions& options = {},
                const feltwire::Hand& held_by = {}, HandPath path = HandPath::taps)
      : law(with_model(mode)),
        servo_options(options),
        scene(floor(stiffness)),
        servo(spec, law, options),
        session({"tester", "floor", spec, law}, scene.views().front()) {
    SimulatedHandOptions how;
    how.spec = spec;
    how.hand = held_by;
    how.task.path = path;
    how.task.depth = 0.012;
    how.task.frequency = 1.5;
    device.emplace(how);
    device->read(now);
    place = device->true_position();
  }
  static Scene floor(double stiffness) {
    Object plane;
    plane.name = "floor";
    plane.shape = Plane{};
    plane.material.stiffness = stiffness;
    return Scene("floor", {plane});
  }

  /// Moves the handle for the time `after` under this force. Assumes a duration of at least `least`
  /// [s] for the energy that the damping dissipates.
  DeviceReading move(Nanoseconds after, const Vec3& force, double least = 0.0) {
    now += after;
    const DeviceReading reading = device->read(now);
    const Vec3 moved = device->true_position() - place;
    place = device->true_position();
    const double time = std::max(least, 1e-9 * static_cast<double>(after.count()));
    left += spec.damping.quadratic(moved) / time + spec.coulomb_friction * moved.lpNorm<1>() -
            force.dot(moved);
    made = std::max(made, -left);
    return reading;
  }
  void tick(Nanoseconds after = kPeriod) {
    const DeviceReading reading = move(after, servo.held().force(), 1e-3);
    servo.hold(device->write(servo.render(reading, now)));
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = servo.sample();
    servo.take(session.take(batch, now).reply, now);
    felt = std::max(felt, servo.held().force().norm());
  }
  void change_to(std::string_view mode) {
    law.mode = mode;
    laws.emplace_back(spec, law, servo_options);
    servo.adopt(laws.back());
  }
  /// Ticks until the hand moves out of the floor under at least this force [N].
  bool comes_out(double force) {
    for (int n = 0; n < 4000; ++n) {
      const double before = place.z();
      tick();
      if (servo.held().force().z() > force && place.z() > before + 2e-5) return true;
    }
    return false;
  }

  DeviceSpec spec = builtin_device("simulated");
  SessionParameters law;
  ServoOptions servo_options;
  Scene scene;
  Servo servo;
  Session session;
  std::optional<SimulatedDevice> device;
  std::deque<ServoLaw> laws;
  Nanoseconds now = seconds(100.0);
  Vec3 place;
  // [J] at the true port: dissipated minus delivered energy; largest excess of the delivered energy
  double left = 0.0, made = 0.0;
  double felt = 0.0;  // [N] largest force on the hand
};

/// Stalls the servo until the account has a debt of some microjoules or more.
void overdraw(Hand& hand, double stall) {
  ASSERT_TRUE(hand.comes_out(0.5));
  hand.tick(seconds(stall));
}

/// The servo stalls for up to two seconds at random moments, and methods and sessions change. The
/// hand may get the energy of a single stall at most. The force must then end.
TEST(Debt, OfAStallIsPaidOrEndsTheForce) {
  int ended = 0, paid = 0;
  double worst_after = 0.0;
  for (const std::uint64_t seed : test::seeds(1, 24, 8)) {
    Random random(seed);
    const auto any = [&] { return kLaws[static_cast<std::size_t>(random.uniform(0.0, 4.999))]; };
    const NamedHand& who = kEightHands[seed % kEightHands.size()];
    Hand hand(any(), random.chance(0.5) ? 5e3 : 40e3, {}, who.hand,
              random.chance(0.5) ? HandPath::taps : HandPath::slide);
    std::optional<double> made;  // [J] excess energy when the force ended
    for (int n = 0; n < 6000; ++n) {
      const bool stalls = random.chance(0.002);
      const std::uint64_t debts = hand.servo.account()->statistics().overdrawn;
      hand.tick(stalls ? seconds(std::abs(random.decades(-2.7, 0.3))) : kPeriod);
      if (stalls && hand.servo.account()->statistics().overdrawn == debts) ++paid;
      if (random.chance(0.002)) hand.change_to(any());
      if (random.chance(0.001)) hand.servo.reconnected(random.chance(0.5));
      if (!hand.servo.overdraft()) {
        EXPECT_LE(hand.made, kLargestDebt + 1e-9) << seed << ' ' << n;
        continue;
      }
      ++ended;
      if (!made) made = hand.made;
      ASSERT_EQ(hand.servo.held().force(), Vec3::Zero()) << seed << ' ' << n;
      worst_after = std::max(worst_after, hand.made - *made);
    }
  }
  EXPECT_LE(worst_after, 0.0) << "and nothing more";
  EXPECT_GT(ended, 100);
  EXPECT_GT(paid, 10);
}

/// Returns the most energy [J] that one of eight hands gets beyond the device's dissipation, in a
/// stall of two seconds during contact. The device holds the last force for `held` [s].
double made_in_a_stall(const char* law, double stiffness, double held) {
  double made = 0.0;
  std::uint64_t seed = 0;
  for (const NamedHand& who : kEightHands)
    for (const HandPath path : {HandPath::press, HandPath::slide, HandPath::taps}) {
      Random random(++seed);
      Hand hand(law, stiffness, {}, who.hand, path);
      const double first = random.uniform(500.0, 1200.0);
      for (int n = 0; n < first || hand.servo.held().force().norm() < 0.1; ++n) {
        if (n > 4000) ADD_FAILURE() << "no force: " << law << ' ' << who.name;
        if (n > 4000) break;
        hand.tick();
      }
      // Short steps resolve the dissipation of the device.
      constexpr Nanoseconds kStep = std::chrono::microseconds(100);
      const Vec3 force = hand.servo.held().force();
      for (Nanoseconds t{0}; t < seconds(held); t += kStep) hand.move(kStep, force);
      hand.device->write({});
      for (Nanoseconds t{0}; t < seconds(2.0 - held); t += kPeriod)
        hand.move(kPeriod, Vec3::Zero());
      made = std::max(made, hand.made);
    }
  return made;
}

/// The stall detector releases the device a few periods after a late tick, however long the stall
/// lasts (client/servo/stall_detector.hpp). The device must dissipate enough until then.
TEST(Debt, NoneIsMadeInTheTimeUntilTheWatchLetsGo) {
  const double held = let_go_time(1e-3, 0.1, 0.0, true);
  for (const char* law : kLaws)
    for (const double stiffness : {1e3, 5e3, 40e3})
      EXPECT_LE(made_in_a_stall(law, stiffness, held), 1e-12) << law << ' ' << stiffness;
}

/// A server can delay a tick: contact takes up to a quarter of a period, and a burst of replies
/// takes less than another quarter. Only the machine causes longer delays.
TEST(Debt, NoneIsMadeByTicksThatAServerMakesLate) {
  constexpr double kLate = 0.65;  // [T]
  for (const char* law : {"shaped", "contact_frame"})
    for (const double stiffness : {5e3, 40e3})
      for (const double often : {0.3, 0.02, 0.0005})
        for (const NamedHand& who : kEightHands) {
          Random random(static_cast<std::uint64_t>(1.0 / often));
          Hand hand(law, stiffness, {}, who.hand, HandPath::taps);
          double before = 0.0;
          for (int n = 0; n < test::rounds(2500); ++n) {
            const double late = random.chance(often) ? kLate : 0.0;
            hand.tick(seconds(1e-3 * (1.0 + late - before)));
            before = late;
          }
          EXPECT_LE(hand.made, 1e-12) << law << ' ' << stiffness << ' ' << often << ' ' << who.name;
          EXPECT_EQ(hand.servo.port().violations(), 0u) << law << ' ' << who.name;
          EXPECT_GT(hand.felt, 0.2);
        }
}

/// Without real-time scheduling the stall detector waits longer.
TEST(Debt, SomeIsMadeInTwentyPeriods) {
  const double held = let_go_time(1e-3, 0.1, 0.0, false);
  EXPECT_GT(made_in_a_stall("shaped", 40e3, held), 1e-4);
}

TEST(Debt, OutlivesALawThatTheServerChanges) {
  for (const char* before : kLaws)
    for (const char* after : kLaws) {
      SCOPED_TRACE(std::string(before) + " -> " + after);
      Hand hand(before, 5e3, {}, {}, HandPath::taps);
      overdraw(hand, 0.3);
      if (!hand.servo.account()->in_debt()) continue;  // The dissipated energy was sufficient.
      const double owed = hand.servo.owed();
      ASSERT_GT(owed, 0.0);
      hand.change_to(after);
      hand.tick();
      EXPECT_FALSE(hand.servo.changes_law());
      EXPECT_NEAR(hand.servo.owed(), owed, 0.05 * owed);
      EXPECT_GT(hand.servo.account()->statistics().largest_debt, 0.99 * owed);
    }
}

/// A new bounding method keeps the balance of dissipated energy.
TEST(Debt, WhatIsLeftOutlivesALawToo) {
  Hand hand("shaped");
  for (int n = 0; n < 700; ++n) hand.tick();
  const double before = hand.servo.account()->balance();
  ASSERT_GT(before, 0.0);
  hand.servo.reconnected(true);
  EXPECT_EQ(hand.servo.account()->balance(), before);
  hand.change_to("contact_frame");
  for (int n = 0; n < 200 && hand.servo.changes_law(); ++n) hand.tick();
  EXPECT_EQ(hand.servo.parameters().mode, "contact_frame");
  EXPECT_GT(hand.servo.account()->balance(), 0.0);
  EXPECT_EQ(hand.servo.port().violations(), 0u);
}

/// The second method has no account. The debt must neither increase nor decrease.
TEST(Debt, OutlivesALawWithoutAnAccount) {
  Hand hand("contact_frame");
  overdraw(hand, 0.3);
  ASSERT_GT(hand.servo.owed(), kLargestDebt);
  const double owed = hand.servo.owed();
  hand.change_to("none");
  for (int n = 0; n < 1000; ++n) hand.tick();
  EXPECT_FALSE(hand.servo.account());
  EXPECT_EQ(hand.servo.owed(), owed);
  EXPECT_EQ(hand.servo.held().force(), Vec3::Zero()) << "the fault stays, whatever law bounds";
  hand.change_to("shaped");
  EXPECT_EQ(hand.servo.account()->balance(), -owed);
}

TEST(Debt, AboveAFewMicrojoulesIsAFaultThatIsTold) {
  Hand hand("contact_frame");
  overdraw(hand, 0.3);
  const auto& overdraft = hand.servo.overdraft();
  ASSERT_TRUE(overdraft);
  EXPECT_GT(overdraft->debt, kLargestDebt);
  EXPECT_NEAR(overdraft->hold_time, 0.3, 1e-9);
  EXPECT_FALSE(overdraft->strong_hand);
  EXPECT_EQ(hand.servo.held(), Command{});
  for (int n = 0; n < 3000; ++n) {
    hand.tick();
    ASSERT_EQ(hand.servo.held(), Command{});
    ASSERT_EQ(hand.servo.no_force(), ZeroForceReason::overdrawn);
  }
  EXPECT_NE(hand.servo.report().reasons & bit(HandReason::debt), 0u);
  const std::string told = text(*overdraft, hand.spec);
  EXPECT_NE(told.find("the force was ended"), std::string::npos) << told;
  EXPECT_NE(told.find("300 ms"), std::string::npos) << told;
  hand.servo.release();
  hand.tick();
  EXPECT_TRUE(hand.servo.let_go());
}

/// Ticks that are microseconds late make a small debt. The device repays the debt by dissipation,
/// and the force continues.
TEST(Debt, ThatIsSmallerIsRepaid) {
  Hand hand("contact_frame");
  std::uint64_t overdrawn = 0;
  for (int n = 0; n < 8000; ++n) hand.tick(kPeriod + Nanoseconds(n % 3 == 0 ? 900 : 0));
  overdrawn = hand.servo.account()->statistics().overdrawn;
  EXPECT_FALSE(hand.servo.overdraft()) << overdrawn;
  EXPECT_GT(hand.felt, 1.0);
}

/// A run that begins with a debt gives no force until the debt is repaid. The run must report no
/// fault.
TEST(Debt, OfAnEarlierRunIsBurnedBeforeAnyForce) {
  constexpr double kOwed = 2e-3;  // [J]
  Hand hand("shaped", 5e3, {.safety = {}, .owed = kOwed});
  EXPECT_EQ(hand.servo.owed(), kOwed);
  bool owes = true;
  for (int n = 0; n < 20'000; ++n) {
    hand.tick();
    owes = owes && hand.servo.account()->in_debt();
    if (owes) {
      ASSERT_EQ(hand.servo.held(), Command{});
    }
  }
  EXPECT_FALSE(owes);
  EXPECT_FALSE(hand.servo.overdraft());
  EXPECT_GT(hand.felt, 1.0);
  EXPECT_GE(hand.left, 0.9 * kOwed) << "it was burned";
}

TEST(Debt, IsKeptForADeviceOfThisProcess) {
  EXPECT_EQ(debt_of("plugin:one"), 0.0);
  settle_debt("plugin:one", 0.0, 0.25);
  settle_debt("plugin:two", 0.0, 0.5);
  EXPECT_EQ(debt_of("plugin:one"), 0.25);
  settle_debt("plugin:one", 0.25, 0.0);
  EXPECT_EQ(debt_of("plugin:one"), 0.0);
  EXPECT_EQ(debt_of("plugin:two"), 0.5);
  // Two at once: neither forgives the other's debt.
  settle_debt("plugin:three", 0.0, 0.25);
  settle_debt("plugin:three", 0.0, 0.0);
  EXPECT_EQ(debt_of("plugin:three"), 0.25);
}

TEST(Debt, TakesNoMemory) {
  Hand hand("contact_frame");
  ASSERT_TRUE(hand.comes_out(0.5));
  hand.laws.emplace_back(hand.spec, with_model("shaped"), ServoOptions{});
  const std::size_t before = test::allocations();
  hand.now += seconds(0.3);
  hand.servo.hold(hand.device->write(hand.servo.render(hand.device->read(hand.now), hand.now)));
  hand.servo.adopt(hand.laws.back());
  for (int n = 0; n < 10; ++n) hand.servo.tick(*hand.device, hand.now += kPeriod);
  EXPECT_EQ(test::allocations() - before, 0u);
  EXPECT_TRUE(hand.servo.overdraft());
}

}  // namespace
}  // namespace feltwire::debt_test
