// A hostile server sends arbitrary body models. The six-degree-of-freedom port must stay passive.

#include <gtest/gtest.h>

#include "client/hands/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "sim/hands/eight_hands.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::body_model_attack_test {
namespace {

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);

/// Returns a valid body model near the hand, with stiff planes and random springs.
BodyModel any_model(test::Random& random, const Pose& about) {
  BodyModel m;
  m.tool = moved(about, 0.002 * random.direction(), 0.1 * random.direction());
  m.reach = random.uniform(0.0, 0.1);
  m.turn = random.uniform(0.0, 2.0);
  m.radius = 0.04;
  m.coupling = {std::pow(10.0, random.uniform(1, 5)), std::pow(10.0, random.uniform(-2, 2)),
                random.uniform(0.1, 50.0), random.uniform(0.01, 5.0)};
  m.slipping = random.uniform(0, 1) < 0.5;
  m.count = static_cast<int>(random.uniform(0.0, kMaxBodyPoints + 0.99));
  m.patch_count = kMaxBodyPatches;
  for (BodyPoint& p : m.points) {
    const Vec3 wide = 0.01 * random.direction();
    p = {0.04 * random.direction(),
         wide * wide.transpose(),
         random.direction(),
         random.uniform(-0.01, 0.005),
         std::pow(10.0, random.uniform(0, 7)),
         static_cast<std::uint8_t>(random.uniform(0.0, kMaxBodyPatches - 0.01))};
  }
  for (BodyPatch& p : m.patches)
    p = {random.uniform(0.5, 2.0),
         random.uniform(0.0, 0.5),
         random.uniform(0.0, 100.0),
         random.uniform(0.0, 0.1),
         random.uniform(0.0, 1.0) * random.direction(),
         0};
  return m;
}

constexpr std::uint64_t kTicks = test::rounds(1500);

/// Returns a random body that make_prefetched_tool() accepts.
FetchedScene any_body(test::Random& random) {
  BodyData body;
  body.coupling = {std::pow(10.0, random.uniform(1, 5)), std::pow(10.0, random.uniform(-2, 2)),
                   random.uniform(0.1, 50.0), random.uniform(0.01, 5.0)};
  body.area = body.contact_area = 1e-3;
  for (int i = 0; i < 60; ++i) body.points.push_back(0.04 * random.direction());
  if (random.uniform(0, 1) < 0.5) {
    body.inertia.mass = std::pow(10.0, random.uniform(-3, 1));
    body.inertia.inertia = 1e-3 * body.inertia.mass * Mat3::Identity();
    body.inertia.gravity = random.uniform(0.0, 100.0) * random.direction();
    body.inertia.damping = random.uniform(0.0, 100.0);
    body.inertia.rotational_damping = random.uniform(0.0, 0.1);
    if (random.uniform(0, 1) < 0.5) body.inertia.integration = ToolIntegration::midpoint;
  }
  std::vector<SolidData> solids;
  for (const Shape& shape : {Shape(Plane{}), Shape(Sphere{0.03}), Shape(Torus{0.05, 0.02})})
    solids.push_back({.object = static_cast<std::uint16_t>(solids.size()),
                      .shape = shape,
                      .from_inside = random.uniform(0, 1) < 0.2,
                      .pose = moved({}, 0.02 * random.direction(), random.direction()),
                      .material = {.stiffness = std::pow(10.0, random.uniform(0, 7)),
                                   .damping = random.uniform(0.0, 100.0),
                                   .static_friction = random.uniform(0.5, 2.0),
                                   .dynamic_friction = random.uniform(0.0, 0.5)}});
  return {.objects = {0, 1, 2}, .surfaces = nullptr, .body = make_prefetched_tool(1, body, solids)};
}

/// Returns the largest energy [J] that the port made. `told` is the device specification that the
/// servo gets.
double energy_made(std::string_view mode, std::uint64_t seed, double* most_torque,
                   const DeviceSpec& told = builtin_device("simulated_6dof")) {
  test::Random random(seed);
  const FetchedScene fetched = any_body(random);
  SimulatedHandOptions hand;
  hand.spec = builtin_device("simulated_6dof");
  hand.hand = with_wrist(kEightHands[seed % kEightHands.size()].hand);
  hand.wrist = {WristPath::tilt, 0.3};
  SimulatedDevice device(hand);
  SessionParameters parameters;
  parameters.mode = mode;
  parameters.local_model = true;
  Servo servo(told, parameters);
  servo.use(&fetched);
  const std::uint64_t delay = seed % 3 * 20, every = 1 + seed % 4;
  for (std::uint64_t n = 1; n <= kTicks; ++n) {
    const Nanoseconds now = static_cast<std::int64_t>(n) * kPeriod;
    const Command given = servo.render(device.read(now), now);
    servo.hold(device.write(given));
    servo.sent();
    *most_torque = std::max(*most_torque, servo.held().torque.norm());
    if (n <= delay || n % every != 0) continue;
    Reply reply;
    reply.sample_index = n - delay;
    reply.rotation = reply.body_modelled = true;
    reply.command.torque = random.uniform(0.0, 1.0) * random.direction();
    reply.command.elastic = random.uniform(0.0, 20.0) * random.direction();
    reply.body = any_model(random, servo.sample().pose);
    reply.body.scene = static_cast<std::uint32_t>(n / 200);
    // The client has not fetched this version.
    if (n / 50 % 2 == 1) reply.body.solids = n % 50 == 0 ? 2 : 1;
    servo.take(reply, now);
  }
  EXPECT_GT(servo.statistics().local_model.from_model + servo.statistics().local_model.from_both,
            0u);
  EXPECT_GT(servo.statistics().local_model.whole, 0u);
  return -servo.port().least_margin();
}

TEST(BodyModelAttack, NoModelMakesThePortGiveEnergy) {
  double torque = 0.0;
  for (const std::uint64_t seed : test::seeds(1, 48, 0))
    EXPECT_LE(energy_made(kSessionMethod, seed, &torque), 1e-9) << seed;
  EXPECT_GT(torque, 0.02);  // [N m] The attack must produce a torque.
}

/// Without a known mass, the energy account assumes a massless hand.
TEST(BodyModelAttack, NorWhereNoMassIsKnown) {
  double torque = 0.0;
  for (const std::uint64_t seed : test::seeds(1, 12, 0))
    EXPECT_LE(energy_made(kSessionMethod, seed, &torque,
                          testing::servo::without_known_mass("simulated_6dof")),
              1e-9)
        << seed;
  EXPECT_GT(torque, 0.01);
}

TEST(BodyModelAttack, WithoutABoundTheSameModelsDo) {
  double torque = 0.0, most = 0.0;
  for (const std::uint64_t seed : test::seeds(1, 8, 0))
    most = std::max(most, energy_made(kUnbounded, seed, &torque));
  EXPECT_GT(most, 1e-3);
}

}  // namespace
}  // namespace feltwire::body_model_attack_test
