// Tests the reachable displacement of the next sample: closed forms, and handles that move as far
// as possible.

#include "core/bounding/reachable_displacement.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/base/numeric.hpp"
#include "tests/core/handle.hpp"

namespace feltwire::reachable_displacement_test {
namespace {

using namespace test;

constexpr double kPeriod = 1e-3;  // [s]
#ifdef FELTWIRE_SANITIZED
constexpr std::uint64_t kDevices = 80;  // Sanitizers make a run forty times as slow.
#else
constexpr std::uint64_t kDevices = 400;
#endif

PortKnowledge knowledge(double mass, double outside, double quantum = 0.0) {
  PortKnowledge k;
  k.mass = mass;
  k.outside_force = outside;
  k.quantum = quantum;
  return k;
}

/// Returns the reachable displacement [m] along x over a period with a held `force` [N] along x.
double along_x(const ReachableDisplacement& reach, double force) {
  return reach.along(Vec3::UnitX(), 1.0, Vec3(force, 0, 0), kPeriod);
}

TEST(ReachableDisplacement, IsNewtonsLawForAHandleWithoutFriction) {
  ReachableDisplacement reach(knowledge(0.1, 5.0));
  EXPECT_FALSE(reach.known());
  reach.moved(Vec3(2e-4, 0, 0), Vec3(3, 0, 0), kPeriod, kPeriod);
  ASSERT_TRUE(reach.known());
  // dx(n+1) - dx(n) is the mean of both samples' largest accelerations times T^2.
  const double mean = 0.5 * ((3.0 + 5.0) + (4.0 + 5.0)) / 0.1;
  EXPECT_NEAR(along_x(reach, 4.0), 2e-4 + mean * kPeriod * kPeriod, 1e-15);
  EXPECT_NEAR(along_x(reach, 5.0) - along_x(reach, 4.0), reach.per_newton(kPeriod), 1e-15);
}

TEST(ReachableDisplacement, AHandleThatFrictionStoppedStartsFromRestAtAnyTime) {
  ReachableDisplacement reach(knowledge(0.1, 5.0));
  reach.moved(Vec3(-1e-3, 0, 0), Vec3::Zero(), kPeriod, kPeriod);
  // Friction may have stopped the handle at once: G0 T^2 + G T^2 / 2.
  EXPECT_NEAR(along_x(reach, 0.0), 1.5 * 50.0 * kPeriod * kPeriod, 1e-15);
}

TEST(ReachableDisplacement, AlongAVectorIsItsLengthTimesThatAlongItsDirection) {
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    ReachableDisplacement reach(knowledge(0.1, 5.0, 3e-5));
    for (int n = random.chance(0.3) ? 2 : 1; n > 0; --n)  // Two short samples count as one.
      reach.moved(random.vector(-6.0, -3.0), random.vector(-1.0, 1.0),
                  random.uniform(0.2, 2.0) * kPeriod, kPeriod);
    const Vec3 v = random.vector(-1.0, 1.0), held = random.vector(-1.0, 1.0);
    const Vec3 coming[] = {random.vector(-1.0, 1.0), random.vector(-1.0, 1.0)};
    const double length = v.norm(), hold = random.uniform(1.0, 2.0) * kPeriod;
    const Vec3 u = v / length;
    const auto same = [&](double whole, double by_unit) {
      EXPECT_NEAR(whole, length * by_unit, 1e-12 * whole);
    };
    same(reach.along(v, length, hold), reach.along(u, 1.0, hold));
    same(reach.along(v, length, held, hold), reach.along(u, 1.0, held, hold));
    same(reach.driven(v, length, coming, hold), reach.driven(u, 1.0, coming, hold));
  }
}

TEST(ReachableDisplacement, NothingIsKnownWithoutAMassAForceOrAMovement) {
  ReachableDisplacement none(knowledge(0.0, 5.0)),
      any(knowledge(0.1, std::numeric_limits<double>::infinity()));
  ReachableDisplacement moved(knowledge(0.1, 5.0));
  for (ReachableDisplacement* r : {&none, &any, &moved})
    r->moved(Vec3::Zero(), Vec3::Zero(), kPeriod, kPeriod);
  EXPECT_FALSE(none.known());
  EXPECT_FALSE(any.known());
  EXPECT_TRUE(moved.known());
  moved.forget();
  EXPECT_FALSE(moved.known());
}

TEST(ReachableDisplacement, KnowledgeThatCannotBeIsRefusedByName) {
  const auto refused = [](const PortKnowledge& k) -> std::string {
    try {
      validate(k, "handle");
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refused(knowledge(0.1, 5.0)), "accepted");
  EXPECT_NE(refused(knowledge(-0.1, 5.0)).find("handle: the mass is -0.1"), std::string::npos);
  EXPECT_NE(refused(knowledge(0.1, -5.0)).find("the outside force"), std::string::npos);
  EXPECT_NE(refused(knowledge(0.1, 5.0, NAN)).find("the encoder quantum"), std::string::npos);
  PortKnowledge friction = knowledge(0.1, 5.0);
  friction.coulomb_friction = INFINITY;
  EXPECT_NE(refused(friction).find("the Coulomb friction"), std::string::npos);
}

/// The largest used fraction of the reachable displacement in any direction, over random devices.
struct Used {
  double most = 0.0;
  long broken = 0, samples = 0;
};

/// Each `told_` argument is an assumed value divided by its true value: mass, hand force and
/// quantum.
Used attack(std::uint64_t seed, double told_mass, double told_force, double told_quantum) {
  Random random(seed);
  Handle handle;
  handle.mass = std::abs(random.decades(-2.0, -0.3));
  handle.viscous = random.chance(0.5) ? std::abs(random.decades(-3.0, 1.5)) : 0.0;
  handle.dry = random.chance(0.5) ? std::abs(random.decades(-2.0, 1.0)) : 0.0;
  const double quantum = random.chance(0.7) ? std::abs(random.decades(-6.0, -4.0)) : 0.0;
  const double strength = std::abs(random.decades(-0.5, 1.3));
  ReachableDisplacement reach(
      knowledge(told_mass * handle.mass, told_force * strength, told_quantum * quantum));
  Used used;
  Vec3 shown = encoded(handle.position, quantum), held = Vec3::Zero();
  const bool even = random.chance(0.4);  // Every hold lasts a period.
  // Ticks are late, but each next tick keeps its deadline.
  const bool deadlines = random.chance(0.5);
  double late = 0.0;
  for (int n = 0; n < 400; ++n) {
    double hold = even ? kPeriod : kPeriod * random.uniform(0.05, 3.0);
    if (deadlines && !even) {
      const double next = random.chance(0.3) ? random.uniform(0.0, 0.9) : 0.0;
      hold = kPeriod * (1.0 + next - late);
      late = next;
    }
    held = random.chance(0.3) ? Vec3::Zero() : random.vector(-1.0, 1.0);
    const Grip grip = any_grip(random);
    constexpr int kParts = 8;
    for (int i = 0; i < kParts; ++i) {
      const Vec3 hand = hand_force(grip, random, held, strength, (i + 0.5) / kParts);
      handle.move(held + hand, hold / kParts);
    }
    const Vec3 now = encoded(handle.position, quantum);
    const Vec3 dx = now - shown;
    if (reach.known()) {
      for (const Vec3& along : {dx, held, random.direction()}) {
        const Vec3 u = direction(along);
        if (u.isZero(0.0)) continue;
        const double share = dx.dot(u) / reach.along(u, 1.0, held, hold);
        used.most = std::max(used.most, share);
        used.broken += share > 1.0 + 1e-9;
        ++used.samples;
      }
    }
    shown = now;
    reach.moved(dx, held, hold, kPeriod);
  }
  return used;
}

Used attack_all(double told_mass, double told_force, double told_quantum) {
  Used all;
  for (std::uint64_t seed = 1; seed <= kDevices; ++seed) {
    const Used used = attack(seed, told_mass, told_force, told_quantum);
    all.most = std::max(all.most, used.most);
    all.broken += used.broken;
    all.samples += used.samples;
  }
  return all;
}

/// A handle without visible movement (docs/bounding.md, "After a tick that is late").
TEST(ReachableDisplacement, AHandleThatStandsReachesNoFartherAfterATickThatIsLate) {
  const double force = 8.0, hand = 10.0, mass = 0.075, q = 3e-5;
  for (const double late : {0.1, 0.3, 0.5}) {
    ReachableDisplacement reach(knowledge(mass, hand, q));
    for (int n = 0; n < 5; ++n) reach.moved(Vec3::Zero(), Vec3(force, 0, 0), kPeriod, kPeriod);
    const double usual = along_x(reach, force);
    EXPECT_NEAR(usual, 1.5 * (force + hand) / mass * kPeriod * kPeriod + q, 1e-15);
    reach.moved(Vec3::Zero(), Vec3(force, 0, 0), (1.0 + late) * kPeriod, kPeriod);
    EXPECT_NEAR(along_x(reach, force), usual, 1e-15) << late;
    reach.moved(Vec3::Zero(), Vec3(force, 0, 0), (1.0 - late) * kPeriod, kPeriod);
    EXPECT_NEAR(along_x(reach, force), usual, 1e-15) << late;
  }
}

/// The hand pushed the handle in, and friction allowed a reversal within the tick.
TEST(ReachableDisplacement, AHandleThatMayHaveTurnedRoundInATickThatIsLateReachesFarther) {
  const double force = 8.0, hand = 10.0, mass = 0.075, q = 3e-5;
  ReachableDisplacement reach(knowledge(mass, hand, q));
  reach.moved(Vec3(-4e-4, 0, 0), Vec3(force, 0, 0), kPeriod, kPeriod);
  reach.moved(Vec3::Zero(), Vec3(force, 0, 0), 1.5 * kPeriod, kPeriod);
  const double turned = along_x(reach, force);
  ReachableDisplacement stands(knowledge(mass, hand, q));
  stands.moved(Vec3::Zero(), Vec3(force, 0, 0), kPeriod, kPeriod);
  EXPECT_GT(turned, 1.1 * along_x(stands, force));
  // Without knowledge of the movement, the reachable displacement is larger: G0 h0 h.
  const double acceleration = (force + hand) / mass;
  EXPECT_LT(turned, 0.9 * (2.0 * acceleration * kPeriod * kPeriod + q));
}

TEST(ReachableDisplacement, NoHandGoesFarther) {
  const Used used = attack_all(1.0, 1.0, 1.0);
  EXPECT_EQ(used.broken, 0);
  EXPECT_GT(used.samples, static_cast<long>(500 * kDevices));
  EXPECT_GT(used.most, 0.98);  // The bound is tight: a hand uses nearly all of it.
}

TEST(ReachableDisplacement, IsBrokenWhenToldWrong) {
  EXPECT_GT(attack_all(1.25, 1.0, 1.0).broken, 0) << "mass told a quarter too large";
  EXPECT_GT(attack_all(1.0, 0.8, 1.0).broken, 0) << "hand told a fifth too weak";
  EXPECT_GT(attack_all(1.0, 1.0, 0.0).broken, 0) << "the encoder's quantum left out";
}

}  // namespace
}  // namespace feltwire::reachable_displacement_test
