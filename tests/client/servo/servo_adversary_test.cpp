// A hand extracts as much energy as possible from a session with a bad network. The servo must
// limit this energy.

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "core/base/numeric.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::servo_adversary_test {
namespace {

using namespace testing::servo;

/// The hand mostly makes the movement that extracts the most energy (dx = f h / 2b). The device
/// holds less force than commanded, fails and recovers. Random replies over six decades are late,
/// lost, reordered or repeated, and the scene changes often. The device holds each force for half a
/// period to a period, plus at most `late` [s].
std::uint64_t violations_against_an_adversary(const SessionParameters& p, std::uint64_t seed,
                                              int ticks, double late = 0.0,
                                              const ServoOptions& options = {}) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto chance = [&](double share) { return unit(random) < share; };
  const auto vector = [&](double least, double most) {
    std::normal_distribution<double> normal;
    const Vec3 v(normal(random), normal(random), normal(random));
    return Vec3(std::pow(10.0, least + (most - least) * unit(random)) * direction(v));
  };
  DeviceSpec spec = builtin_device("simulated");
  Servo servo(spec, p, options);
  std::deque<std::pair<Nanoseconds, Reply>> under_way;
  Nanoseconds now = seconds(5.0);
  Vec3 position = Vec3::Zero();
  Command command;
  std::uint8_t reloads = 0;
  for (int i = 0; i < ticks; ++i) {
    const double hold =
        1e-3 * (0.5 + 0.5 * unit(random)) + (late > 0.0 ? (0.5e-3 + late) * unit(random) : 0.0);
    now += seconds(hold);
    position += chance(0.1) ? vector(-7, -2)
                            : Vec3(hold / (2.0 * spec.damping.least()) * servo.held().force());
    std::erase_if(under_way, [&](const auto& entry) {
      if (entry.first > now) return false;
      servo.take(entry.second, entry.first);
      return !chance(0.05);  // Some replies arrive twice.
    });
    DeviceReading reading{.pose = {.position = position}, .ok = !chance(0.002)};
    Command given = servo.render(reading, now);
    if (chance(0.02)) given = unit(random) * given;
    const Sample* sample = servo.hold(given);
    if (sample == nullptr || chance(0.05)) continue;
    if (chance(0.1)) command = {.elastic = vector(-3, 3), .frictional = vector(-3, 3)};
    if (chance(0.05)) ++reloads;
    Reply answer = reply(sample->index, command);
    answer.reloads = reloads;
    under_way.emplace_back(now + seconds(0.05 * unit(random)), answer);
  }
  EXPECT_GT(servo.statistics().replies.answered, 0u);
  EXPECT_GT(servo.statistics().max_force, 0.1);  // [N] The attack must produce a force.
  return servo.port().violations();
}

TEST(ServoAdversary, NoNetworkNoHandAndNoFaultGetsEnergyOutOfTheContactFrame) {
  for (const Projection projection : {Projection::joint, Projection::cone}) {
    SessionParameters p = parameters("contact_frame");
    p.projection = projection;
    for (const std::uint64_t seed : test::seeds(1, 40, 4))
      EXPECT_EQ(violations_against_an_adversary(p, seed, 4000), 0u) << seed;
  }
}

// No real machine wakes a thread exactly on time.
TEST(ServoAdversary, TicksThatAreLateGiveItNothing) {
  for (const BoundingSide side : {BoundingSide::client, BoundingSide::both, BoundingSide::server})
    for (const Storage storage : {Storage::minimal, Storage::elastic})
      for (const double late : {30e-9, 3e-6, 50e-6, 400e-6}) {
        SessionParameters p = parameters("contact_frame", side);
        p.storage = storage;
        for (const std::uint64_t seed : test::seeds(1, 10, 0))
          EXPECT_EQ(violations_against_an_adversary(p, seed, 4000, late), 0u)
              << name(side) << ' ' << name(storage) << ' ' << late << ' ' << seed;
      }
}

// The bound includes the damping that an operator claims. The account includes only the energy that
// the device dissipates.
TEST(ServoAdversary, AnOperatorWhoIsNotThereIsSeenInTheAccount) {
  for (const double claimed : {0.5, 5.0, 100.0}) {
    SessionParameters p = parameters("contact_frame");
    p.operator_damping = claimed;
    EXPECT_GT(violations_against_an_adversary(p, 1, 4000), 0u) << claimed;
    p.side = BoundingSide::server;  // The client's account gives only what the device dissipated.
    EXPECT_EQ(violations_against_an_adversary(p, 1, 4000), 0u) << claimed;
  }
}

// A constant force moves the hand. The bound therefore stays at its limit.
TEST(ServoAdversary, AConstantForceIsNoViolationBecauseTicksAreNotExact) {
  for (const double late : {20e-9, 5e-6, 60e-6}) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    Bench bench(parameters("contact_frame"));
    double due = 0.0, before = 0.0, z = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      due += 1e-3;
      const double at_time = due + late * unit(random);
      z += 0.05 * (at_time - before);
      if (bench.servo.sample().index > 0)
        bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 1.0)), bench.now);
      bench.tick(at(0, 0, z), seconds(at_time - before));
      before = at_time;
    }
    EXPECT_GT(bench.servo.port().delivered().elastic, 1e-3);
    EXPECT_EQ(bench.servo.port().violations(), 0u) << late;
  }
}

TEST(ServoAdversary, WithoutABoundTheSameAdversaryGetsIt) {
  EXPECT_GT(violations_against_an_adversary(parameters("none"), 1, 4000), 0u);
  EXPECT_GT(violations_against_an_adversary(parameters("none", BoundingSide::server), 1, 4000), 0u);
}

/// The test includes published methods. Some are not passive by themselves, and no method is
/// passive if a tick is late.
TEST(ServoAdversary, BehindItsAccountNoModeGivesMoreThanWasBurned) {
  for (const BoundingMethod* method : bounding_methods()) {
    // shaped_adversary_test.cpp attacks accounts that use the hand's mass and force.
    if (method->name == kUnbounded || method->shapes || stands_beside_scene(*method)) continue;
    for (const double late : {0.0, 50e-6, 400e-6})
      for (const std::uint64_t seed : test::seeds(1, 4, 0))
        EXPECT_EQ(violations_against_an_adversary(parameters(method->name), seed, 4000, late), 0u)
            << method->name << ' ' << late << ' ' << seed;
  }
  ServoOptions as_published;
  as_published.account = false;
  for (const char* mode : {"total_energy", "passivity_control", "passivity_control_directional"})
    EXPECT_GT(violations_against_an_adversary(parameters(mode), 1, 4000, 0.0, as_published), 0u)
        << mode;
}

TEST(ServoAdversary, WhereTheServerBoundsTheAdversaryGetsNoMoreThanWasBurned) {
  for (const std::string_view mode :
       {"contact_frame", "per_axis_projected", "total_energy", "virtual_coupling"})
    EXPECT_EQ(violations_against_an_adversary(parameters(mode, BoundingSide::server), 1, 4000), 0u)
        << mode;
}

}  // namespace
}  // namespace feltwire::servo_adversary_test
