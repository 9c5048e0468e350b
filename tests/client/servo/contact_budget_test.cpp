// A server must not make a client's tick too long. The servo stops a contact computation that
// exceeds its budget, and uses the reply's command. This change of the command must give the hand
// no energy.

#include "core/local_model/contact_budget.hpp"

#include <gtest/gtest.h>

#include "client/servo/servo.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/client/touched_surfaces.hpp"
#include "tests/core/heavy_geometry.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::contact_budget_test {
namespace {

using testing::servo::Bench;
using testing::servo::without_known_mass;

constexpr std::uint32_t kVersion = 5;

SessionParameters modelled(std::string_view mode) {
  SessionParameters p;
  p.mode = mode;
  p.local_model = true;
  return p;
}

FetchedScene limited(FetchedScene scene) {
  scene.most_work = units_within(contact_budget(1e-3));
  return scene;
}

struct Attack {
  std::uint64_t cut = 0, most_work = 0, violations = 0;
  std::size_t allocations = 0;
  double held = 0.0;  // [N] the largest force
};

/// A hand presses, and then extracts as much energy as possible from the force. `model` adds a
/// touched surface to each reply. A tick over its budget must use the reply's command.
template <class Model>
Attack attacked(Bench& bench, test::Random& random, Model model) {
  constexpr int kTicks = test::rounds(600), kPress = 20;
  constexpr double kWay = 5e-5, kFar = 3e-3;  // [m]
  const double damping = bench.spec.damping.least();
  Attack attack;
  Vec3 position = Vec3::Zero();
  const std::size_t before = test::allocations();
  for (int n = 0; n < kTicks; ++n) {
    if (n > 0) {
      Reply reply;
      reply.sample_index = bench.servo.sample().index;
      reply.command.elastic = Vec3(0, 0, 5) + 0.1 * random.direction();
      model(reply, position);
      bench.servo.take(reply, bench.now);
    }
    const bool presses = n / kPress % 2 == 0;
    position +=
        presses ? Vec3(0, 0, -kWay) : test::greediest(bench.servo.held().force(), 1e-3, damping);
    if (position.norm() > kFar) position *= 0.9;
    const std::uint64_t cut = bench.servo.statistics().local_model.contact_cut;
    bench.tick({.pose = {.position = position}});
    attack.held = std::max(attack.held, bench.servo.held().force().norm());
    if (bench.servo.statistics().local_model.contact_cut == cut) continue;
    EXPECT_TRUE(bench.servo.command() == bench.servo.newest_reply().command) << n;
    EXPECT_FALSE(bench.servo.near());
  }
  attack.allocations = test::allocations() - before;
  attack.cut = bench.servo.statistics().local_model.contact_cut;
  attack.most_work = bench.servo.statistics().local_model.most_work;
  attack.violations = bench.servo.port().violations();
  return attack;
}

void mark_as_touched(Reply& reply, const Vec3& hand) {
  testing::mark_as_touched(reply, kVersion, hand);
}

void expect_cut_in_time(const Attack& attack, const FetchedScene& scene, std::string_view mode) {
  EXPECT_GT(attack.cut, 0u) << mode;
  EXPECT_LE(attack.most_work, scene.most_work);
  EXPECT_EQ(attack.violations, 0u) << mode;
  EXPECT_EQ(attack.allocations, 0u);
}

TEST(ContactBudget, NoSurfaceMakesATickLong) {
  constexpr std::size_t kTriangles = 20'000;
  for (const double radius : {0.0, 2e-3}) {
    SurfaceData knot = test::through_a_point(kTriangles), corner = test::round_a_corner(kTriangles);
    knot.radius = corner.radius = radius;
    for (const SurfaceData& lie : {knot, corner})
      for (const std::string_view mode : {kSessionMethod, std::string_view("contact_frame")}) {
        const FetchedScene scene =
            limited({.objects = {0}, .surfaces = mesh_surfaces(kVersion, {lie}), .body = nullptr});
        Bench bench(modelled(mode), without_known_mass());  // The simulated hand has no mass.
        bench.servo.use(&scene);
        test::Random random(3);
        const Attack attack = attacked(bench, random, mark_as_touched);
        expect_cut_in_time(attack, scene, mode);
        EXPECT_GT(attack.held, 0.0);
      }
  }
}

void hold_the_tool_there(Reply& reply, const Vec3& hand) {
  reply.body_modelled = reply.rotation = true;
  reply.body.solids = kVersion;
  reply.body.tool.position = hand;
  reply.body.reach = 0.1;
  reply.body.turn = 1.0;
  reply.body.coupling = {1000.0, 1.0, 20.0, 1.0};
  reply.body.radius = 0.04;
}

TEST(ContactBudget, NoBodyMakesATickLong) {
  for (const std::string_view mode : {kSessionMethod, std::string_view("contact_frame")}) {
    const FetchedScene scene =
        limited({.objects = {},
                 .surfaces = nullptr,
                 .body = make_prefetched_tool(kVersion, test::ball_of_points(20'000),
                                              test::thin_boxes(150))});
    Bench bench(modelled(mode), without_known_mass());
    bench.servo.use(&scene);
    test::Random random(4);
    expect_cut_in_time(attacked(bench, random, hold_the_tool_there), scene, mode);
  }
}

/// The `shaped` method relies on the device's mass, but the simulated hand has none. The hand gets
/// too much energy once. The energy account must measure the same energy as the counter, report a
/// hand of excess strength, and end the force.
TEST(ContactBudget, AHandWithoutTheMassThatWasToldGetsOneDebtThatIsCalledAStrongHand) {
  const FetchedScene scene =
      limited({.objects = {},
               .surfaces = nullptr,
               .body = make_prefetched_tool(kVersion, test::ball_of_points(20'000),
                                            test::thin_boxes(150))});
  Bench bench(modelled(kSessionMethod));
  bench.servo.use(&scene);
  test::Random random(4);
  EXPECT_GT(attacked(bench, random, hold_the_tool_there).violations, 0u);
  ASSERT_TRUE(bench.servo.overdraft());
  EXPECT_TRUE(bench.servo.overdraft()->strong_hand);
  const AccountStatistics& account = bench.servo.account()->statistics();
  EXPECT_EQ(account.overdrawn, 1u);
  EXPECT_NEAR(account.largest_debt, -bench.servo.port().least_margin(), 1e-12);
  EXPECT_EQ(bench.servo.held(), Command{});
}

/// Planes need no prefetched geometry. A fast servo has at least 100 us per tick for planes.
TEST(ContactBudget, NoPlanesMakeATickLong) {
  EXPECT_EQ(plane_work(1e-3), units_within(250e-6));
  EXPECT_EQ(plane_work(1e-4), units_within(100e-6));
  const auto planes = [](Reply& reply, const Vec3& hand) {
    hold_the_tool_there(reply, hand);
    reply.body.solids = 0;
    reply.body.count = kMaxBodyPoints;
    reply.body.patch_count = kMaxBodyPatches;
    for (std::size_t i = 0; i < kMaxBodyPoints; ++i)
      reply.body.points[i] = {.arm = 0.04 * test::spread_direction(i, kMaxBodyPoints),
                              .spread = 1e-6 * Mat3::Identity(),
                              .normal = test::spread_direction(3 * i % kMaxBodyPoints, 15),
                              .distance = -1e-3,
                              .stiffness = 1e3,
                              .patch = static_cast<std::uint8_t>(i % kMaxBodyPatches)};
    for (BodyPatch& patch : reply.body.patches) {
      patch.static_friction = 1.0;
      patch.dynamic_friction = 0.5;
      patch.velocity = Vec3(0.3, 0.2, 0.1);
    }
  };
  SessionParameters fast = modelled(kSessionMethod);
  fast.servo_period = 1e-5;
  Bench bench(fast);
  test::Random random(5);
  const Attack attack = attacked(bench, random, planes);
  EXPECT_LE(attack.most_work, plane_work(fast.servo_period));
  EXPECT_GT(attack.most_work, 0u);
}

}  // namespace
}  // namespace feltwire::contact_budget_test
