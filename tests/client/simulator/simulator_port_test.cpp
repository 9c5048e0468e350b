// A simulator in the place of a server, at 60 to 1000 Hz, with a hand at 1 kHz.

#include "client/simulator/simulator_port.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "client/hands/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "client/simulator/simulator_session.hpp"
#include "client/transport/transport.hpp"
#include "core/base/numeric.hpp"

namespace feltwire::simulator_port_test {
namespace {

constexpr double kStiffness = 5000.0;  // [N/m]
constexpr double kRadius = 0.05;       // [m] of the sphere
const Vec3 kCenter(0.0, 0.0, -kRadius);

/// Returns the sphere's surface near the tool.
SimulatorContact sphere_near(const Vec3& tool, Nanoseconds seen) {
  SimulatorContact contact;
  contact.seen = seen;
  contact.modelled = true;
  contact.model.reach = 0.02;
  contact.model.count = 1;
  SurfacePatch& patch = contact.model.patches.front();
  patch.normal = (tool - kCenter).normalized();
  patch.point = kCenter + kRadius * patch.normal;
  patch.curvature = 1.0 / kRadius;
  patch.radius = 0.03;
  patch.material.stiffness = kStiffness;
  return contact;
}

Vec3 force_of_sphere(const Vec3& tool) {
  const Vec3 away = tool - kCenter;
  const double depth = kRadius - length(away);
  return depth > 0.0 ? Vec3(kStiffness * depth * away.normalized()) : Vec3::Zero();
}

Nanoseconds test_time{0};
Nanoseconds time_of_test() noexcept { return test_time; }

/// A hand and a simulator, in simulated time. A tick is 1 ms.
class World {
 public:
  using Physics = std::function<SimulatorContact(const Vec3& tool, Nanoseconds seen)>;
  static constexpr Nanoseconds kTick = std::chrono::milliseconds(1);

  explicit World(HandPath path, Physics physics = sphere_near, double stiffness = kStiffness)
      : World(made(path, stiffness), std::move(physics)) {}

  /// Makes a tick. The simulator answers every `every` ticks, with the pose of `late` ticks before.
  void tick(int every, int late = 0) {
    now_ += kTick;
    test_time = now_;
    Reply reply;
    GoodbyeReason reason{};
    while (transport_.receive(reply, reason) == Transport::Arrival::reply)
      replies_ += servo_.take(reply, now_) ? 1 : 0;
    const Sample* sample = servo_.tick(device_, now_);
    ASSERT_NE(sample, nullptr);
    poses_.push_back({sample->pose.position, now_});
    if (transport_.send(*sample)) servo_.sent();
    ++ticks_;
    if (every == 0 || ticks_ % every != 0 || ticks_ <= late) return;
    const auto& [tool, seen] = poses_[poses_.size() - 1 - static_cast<std::size_t>(late)];
    feed_->put(physics_(tool, seen));
  }

  bool put(const SimulatorContact& contact) { return feed_->put(contact); }

  Servo& servo() { return servo_; }
  SimulatedDevice& device() { return device_; }
  const Vec3& tool() const { return poses_.back().first; }
  int replies() const { return replies_; }
  std::uint64_t dropped() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : transport_.statistics().dropped) sum += count;
    return sum;
  }

 private:
  struct Made {
    RunOptions options;
    std::shared_ptr<SimulatorFeed> feed;
    Joined joined;
    SimulatedHandOptions hand;
  };
  static Made made(HandPath path, double stiffness) {
    Made made;
    made.hand.spec = builtin_device("simulated");
    made.hand.task.path = path;
    made.feed = meet_simulator(made.options, {.stiffness = stiffness});
    made.joined = made.options.hooks.join(
        {"test", "own", made.hand.spec, made.options.parameters, Role::operator_});
    return made;
  }
  World(Made made, Physics physics)
      : feed_(made.feed),
        physics_(std::move(physics)),
        device_(made.hand),
        transport_({made.joined.datagrams, made.joined.accepted.session, made.joined.keys},
                   made.joined.accepted.parameters, false,
                   std::make_unique<SimulatorPort>(made.joined.accepted.session, made.joined.keys,
                                                   made.feed, time_of_test)),
        servo_(device_.spec(), made.joined.accepted.parameters, options(made.joined.accepted)) {
    device_.begin(made.joined.accepted.start_position, made.joined.accepted.start_normal);
  }
  static ServoOptions options(const control::JoinAccepted& accepted) {
    ServoOptions options = protect_hand(accepted.parameters);
    options.scene_stiffness = accepted.stiffness;
    return options;
  }

  std::shared_ptr<SimulatorFeed> feed_;
  Physics physics_;
  SimulatedDevice device_;
  Transport transport_;
  Servo servo_;
  Nanoseconds now_ = std::chrono::seconds(1000);
  std::vector<std::pair<Vec3, Nanoseconds>> poses_;
  int ticks_ = 0, replies_ = 0;
};

struct Felt {
  std::vector<Vec3> forces;  // [N] of the environment, a tick each
  double made = 0.0;         // [J] by the true motors, beyond what their friction burned
};

Felt slide_on_sphere(int every, int late) {
  World world(HandPath::slide);
  Felt felt;
  for (int i = 0; i < 6000; ++i) {
    world.tick(every, late);
    felt.forces.push_back(world.servo().command().force());
  }
  EXPECT_EQ(world.servo().port().violations(), 0u);
  EXPECT_EQ(world.dropped(), 0u);
  felt.made = world.device().true_energy().made;
  return felt;
}

// Python may need some milliseconds for its physics. A curved patch is known between its answers,
// so the hand feels what it feels with an answer at each of its ticks.
TEST(SimulatorPort, ASlowSimulatorIsFeltAsAFastOne) {
  const Felt fast = slide_on_sphere(1, 0);
  EXPECT_LT(fast.made, 1e-9);
  double most = 0.0;
  for (const Vec3& force : fast.forces) most = std::max(most, length(force));
  EXPECT_GT(most, 1.0);
  for (const auto& [every, late] : {std::pair{5, 4}, {10, 5}, {17, 16}}) {
    const Felt slow = slide_on_sphere(every, late);
    EXPECT_LT(slow.made, 1e-9) << every;
    double worst = 0.0;
    for (std::size_t i = 0; i < fast.forces.size(); ++i)
      worst = std::max(worst, length(slow.forces[i] - fast.forces[i]));
    EXPECT_LT(worst, 0.02 * most) << every;
  }
}

TEST(SimulatorPort, EachContactIsAnsweredOnceAndNothingCountsAsLost) {
  World world(HandPath::press);
  for (int i = 0; i < 2000; ++i) world.tick(10);
  EXPECT_NEAR(world.replies(), 200, 2);
  EXPECT_EQ(world.servo().lost(), 0u);
}

// The physics stands still for half a second. A hand that is inside the sphere then feels it again
// when it has come out.
TEST(SimulatorPort, StalePhysicsFadesAndComesBackWithoutEnergy) {
  for (const int begin : {1300, 1500, 1700, 1900, 2100}) {
    World world(HandPath::taps);
    double before = 0.0, after = 0.0;
    for (int i = 0; i < 6000; ++i) {
      const bool stands = i >= begin && i < begin + 500;
      world.tick(stands ? 0 : 10, 3);
      const double force = length(world.servo().held().force());
      if (stands && i >= begin + 110) {
        EXPECT_EQ(force, 0.0) << i;
      }
      (i < begin ? before : after) = std::max(i < begin ? before : after, force);
    }
    EXPECT_GT(before, 0.5);
    EXPECT_GT(after, 0.9 * before);
    EXPECT_LT(world.device().true_energy().made, 1e-9) << begin;
    EXPECT_EQ(world.servo().port().violations(), 0u);
  }
}

// A floor rises at 20 mm/s. The simulator is 8 ms late, and answers at 60 Hz.
TEST(SimulatorPort, ASurfaceThatMovesIsMovedOn) {
  static constexpr double kSpeed = 0.02;
  const auto floor = [](const Vec3& /*tool*/, Nanoseconds seen) {
    SimulatorContact contact = sphere_near({0, 0, 0}, seen);
    SurfacePatch& patch = contact.model.patches.front();
    patch.curvature = 0.0;
    patch.point = {0, 0, -0.02 + kSpeed * seconds(seen - std::chrono::seconds(1000))};
    patch.velocity = {0, 0, kSpeed};
    contact.model.reach = 0.05;
    patch.radius = 0.1;
    patch.material.stiffness = 500.0;
    return contact;
  };
  World world(HandPath::press, floor, 500.0);
  int touched = 0;
  for (int i = 1; i <= 2000; ++i) {
    world.tick(16, 8);
    const double depth = -0.02 + kSpeed * 1e-3 * i - world.tool().z();
    if (i < 100 || depth < 1e-3) continue;
    ++touched;
    // The bound may ask for the force at a place some encoder steps away.
    EXPECT_NEAR(world.servo().command().force().z(), 500.0 * depth, 500.0 * 2e-5) << i;
  }
  EXPECT_GT(touched, 100);
}

TEST(SimulatorPort, AForceWithAStiffnessIsAPlane) {
  const auto spring = [](const Vec3& tool, Nanoseconds seen) {
    SimulatorContact contact;
    contact.seen = seen;
    contact.command.elastic = force_of_sphere(tool);
    contact.stiffness = kStiffness;
    return contact;
  };
  World world(HandPath::press, spring);
  double worst = 0.0, most = 0.0;
  for (int i = 0; i < 4000; ++i) {
    world.tick(10, 5);
    if (i < 1500) continue;
    worst =
        std::max(worst, length(world.servo().command().force() - force_of_sphere(world.tool())));
    most = std::max(most, length(force_of_sphere(world.tool())));
  }
  EXPECT_GT(most, 1.0);
  EXPECT_LT(worst, 0.02 * most);
  EXPECT_LT(world.device().true_energy().made, 1e-9);
}

// A simulator that is wrong in every answer: surfaces appear, vanish, jump and turn under the hand.
TEST(SimulatorPort, AWrongSimulatorMakesNoEnergy) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    const auto wrong = [&](const Vec3& tool, Nanoseconds seen) {
      std::normal_distribution<double> normal;
      std::uniform_real_distribution<double> share(0.0, 1.0);
      const auto direction = [&] { return Vec3(normal(random), normal(random), normal(random)); };
      SimulatorContact contact = sphere_near(tool, seen);
      contact.modelled = share(random) < 0.8;
      contact.command.elastic = 8.0 * direction();
      contact.stiffness = share(random) < 0.5 ? kStiffness * share(random) : 0.0;
      contact.model.count = static_cast<int>(4.0 * share(random));
      for (SurfacePatch& patch : contact.model.patches) {
        patch = contact.model.patches.front();
        patch.normal = direction().normalized();
        patch.point = tool + 5e-3 * direction();
        patch.velocity = 0.2 * direction();
        patch.material.stiffness = kStiffness * (0.01 + share(random));
        patch.material.static_friction = patch.material.dynamic_friction = share(random);
      }
      return contact;
    };
    World world(HandPath::slide, wrong);
    for (int i = 0; i < 5000; ++i) world.tick(1 + static_cast<int>(random() % 20));
    EXPECT_GT(world.replies(), 100) << seed;
    EXPECT_LT(world.device().true_energy().made, 1e-9) << seed;
    EXPECT_EQ(world.servo().port().violations(), 0u) << seed;
  }
}

TEST(SimulatorPort, AFloodOfContactsLeavesTheNewestOnes) {
  World world(HandPath::press);
  for (int i = 0; i < 100; ++i) world.tick(1);
  EXPECT_NEAR(world.replies(), 99, 1);
  for (int i = 0; i < 100; ++i) world.put(sphere_near(world.tool(), {}));
  for (int i = 0; i < 10; ++i) world.tick(0);
  EXPECT_NEAR(world.replies(), 100, 1);
}

TEST(SimulatorPort, WrongOptionsAreNamed) {
  RunOptions options;
  EXPECT_THROW(meet_simulator(options, {.stiffness = 0.0}), std::invalid_argument);
  EXPECT_THROW(meet_simulator(options, {.stiffness = 1e10}), std::invalid_argument);
  EXPECT_THROW(meet_simulator(options, {.stiffness = 1.0, .start_normal = Vec3(0, 0, 2)}),
               std::invalid_argument);
  options.parameters.side = BoundingSide::server;
  EXPECT_THROW(meet_simulator(options, {.stiffness = 1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::simulator_port_test
