// A hostile server sends random surfaces that jump from reply to reply. The hand must not get more
// energy than the device dissipates.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"

namespace feltwire::model_attack_test {
namespace {

using test::Random;
using testing::servo::Bench;
using testing::servo::kPeriod;

std::vector<SessionParameters> laws() {
  std::vector<SessionParameters> all(4);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].projection = i % 2 == 0 ? Projection::joint : Projection::cone;
    all[i].storage = i / 2 == 0 ? Storage::minimal : Storage::elastic;
  }
  SessionParameters tank;
  tank.mode = "energy_tank";
  all.push_back(tank);
  SessionParameters shaped;
  shaped.mode = "shaped";
  all.push_back(shaped);
  for (SessionParameters& p : all) {
    p.side = BoundingSide::client;
    p.local_model = true;
  }
  return all;
}

/// Returns a random patch that PROTOCOL.md allows, near the hand or far from it.
SurfacePatch any_patch(Random& random, const Vec3& hand) {
  SurfacePatch p;
  p.point = hand + random.vector(-6.0, -1.0);
  p.normal = random.direction();
  if (random.chance(0.7)) p.curvature = random.decades(-3.0, 3.0);
  if (random.chance(0.4)) p.axis = random.direction();
  if (random.chance(0.5)) p.velocity = random.vector(-3.0, 2.0);
  p.radius = random.chance(0.7) ? 1.0 : std::abs(random.decades(-5.0, 0.0));
  p.anchor = hand + random.vector(-6.0, 1.0);
  p.touching = random.chance(0.5);
  p.slipping = random.chance(0.3);
  p.joined = random.chance(0.4);
  p.faceted = random.chance(0.3);
  p.rough = random.chance(0.3);
  if (random.chance(0.3)) p.offset = random.decades(-5.0, 0.0);
  p.object = static_cast<std::uint16_t>(random.uniform(0.0, 3.0));
  p.feature = static_cast<std::uint8_t>(random.uniform(0.0, 4.0));
  p.material.stiffness = std::abs(random.decades(0.0, 6.0));
  if (random.chance(0.5)) p.material.damping = std::abs(random.decades(-2.0, 3.0));
  if (random.chance(0.5)) p.material.static_friction = std::abs(random.decades(-2.0, 2.0));
  p.material.dynamic_friction = random.uniform(0.0, p.material.static_friction);
  if (random.chance(0.5)) p.material.viscous_friction = std::abs(random.decades(-2.0, 3.0));
  return p;
}

struct Attack {
  std::uint64_t violations = 0, modelled = 0;
  double rendered = 0.0;  // [N] sum over all ticks
};

/// A hand extracts as much energy as possible from the held force. Every few ticks a reply brings a
/// new local model, which `next` makes for the hand's position.
template <class Next>
Attack attacked(const SessionParameters& parameters, Random& random, int every, Next next) {
  Bench bench(parameters, testing::servo::without_known_mass());  // The simulated hand has no mass.
  const double damping = bench.spec.damping.least();
  Vec3 position = Vec3::Zero();
  Attack attack;
  for (int n = 0; n < 400; ++n) {
    if (n > 0 && n % every == 0) {
      Reply reply;
      reply.sample_index = bench.servo.sample().index;
      reply.modelled = true;
      next(reply, position);
      bench.servo.take(reply, bench.now);
    }
    const double share = random.chance(0.7) ? 1.0 : random.uniform(-3.0, 3.0);
    position += share * test::greediest(bench.servo.held().force(), 1e-3, damping);
    if (random.chance(0.5)) position += random.vector(-7.0, -3.5);
    attack.rendered += bench.tick({.pose = {.position = position}}).force().norm();
  }
  attack.violations = bench.servo.port().violations();
  attack.modelled = bench.servo.statistics().local_model.from_model +
                    bench.servo.statistics().local_model.from_both;
  return attack;
}

/// Fills the reply with a random valid local model.
void random_model(Random& random, Reply& reply, const Vec3& hand) {
  reply.command.elastic = random.vector(-2.0, 2.0);
  reply.model.center = hand + random.vector(-6.0, -2.0);
  reply.model.reach = std::abs(random.decades(-4.0, 0.0));
  reply.model.count = static_cast<int>(random.uniform(0.0, 4.0));
  for (SurfacePatch& patch : reply.model.patches) patch = any_patch(random, hand);
}

/// Puts a wall near the hand, at a new height in every reply.
void jumping_wall(Random& random, Reply& reply, const Vec3& hand) {
  reply.model.center = hand;
  reply.model.reach = 0.1;
  reply.model.count = 1;
  SurfacePatch& wall = reply.model.patches[0];
  wall = {};
  wall.point = hand + Vec3(0.0, 0.0, random.uniform(-5e-3, 5e-3));
  wall.radius = 0.1;
  wall.material.stiffness = 2000.0;
}

RC_GTEST_PROP(ModelAttack, NoModelGivesTheHandMoreThanWasBurned, ()) {
  Random random(*rc::gen::arbitrary<std::uint64_t>());
  const auto all = laws();
  const auto which = static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(all.size())));
  const int every = *rc::gen::inRange(1, 30);
  const bool jumps = *rc::gen::arbitrary<bool>();
  const Attack attack = attacked(all[which], random, every, [&](Reply& reply, const Vec3& hand) {
    jumps ? jumping_wall(random, reply, hand) : random_model(random, reply, hand);
  });
  RC_ASSERT(attack.violations == 0u);
}

// Without a bound these hands must extract energy. Otherwise the test above could not fail.
TEST(ModelAttackMutant, WithoutABoundTheSameModelsOverdraw) {
  SessionParameters bounded = laws()[0], unbounded = laws()[0];
  unbounded.mode = "none";
  Attack kept, lost, jumped;
  const auto add = [](Attack& sum, const Attack& a) {
    sum.violations += a.violations;
    sum.modelled += a.modelled;
    sum.rendered += a.rendered;
  };
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto any = [&](Random& random) {
      return [&random](Reply& reply, const Vec3& hand) { random_model(random, reply, hand); };
    };
    Random a(seed), b(seed), c(seed);
    add(kept, attacked(bounded, a, 10, any(a)));
    add(lost, attacked(unbounded, b, 10, any(b)));
    add(jumped, attacked(unbounded, c, 10,
                         [&c](Reply& reply, const Vec3& hand) { jumping_wall(c, reply, hand); }));
  }
  EXPECT_EQ(kept.violations, 0u);
  EXPECT_GT(kept.modelled, 1000u);
  EXPECT_GT(kept.rendered, 100.0);
  EXPECT_GT(lost.violations, 0u);
  EXPECT_GT(jumped.violations, 0u);
}

}  // namespace
}  // namespace feltwire::model_attack_test
