// A scene changes under a hand. The force must never jump, for any old and new scene.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "server/scene/session.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::reload_force_test {
namespace {

using namespace testing::servo;
using test::Random;

constexpr double kTick = 1e-3;  // [s]

Quaternion turn(Random& random, double most) {
  return Quaternion(Eigen::AngleAxisd(random.uniform(-most, most), random.direction()));
}

Material material(Random& random) {
  Material m;
  m.stiffness = std::pow(10.0, random.uniform(1.0, 4.5));
  if (random.chance(0.5)) {
    m.static_friction = random.uniform(0.0, 1.5);
    m.dynamic_friction = random.uniform(0.0, 1.0) * m.static_friction;
  }
  if (random.chance(0.3)) m.damping = random.uniform(0.0, 5.0);
  if (random.chance(0.3)) m.viscous_friction = random.uniform(0.0, 5.0);
  return m;
}

/// Returns a scene with one to three solids. Their surfaces are near the origin.
Scene scene(Random& random) {
  std::vector<Object> objects;
  const int count = 1 + static_cast<int>(random.uniform(0.0, 2.999));
  for (int i = 0; i < count; ++i) {
    Object object;
    object.name = "o" + std::to_string(i);
    object.material = material(random);
    const double size = random.uniform(0.01, 0.05), up = random.uniform(-0.006, 0.006);
    object.pose.orientation = turn(random, 0.3);
    object.pose.position = Vec3(0.0, 0.0, up - size);
    if (random.chance(0.4)) {
      object.shape = Plane{};
      object.pose.position.z() = up;
    } else if (random.chance(0.5)) {
      object.shape = Sphere{size};
    } else if (random.chance(0.5)) {
      object.shape = Box{Vec3(0.05, 0.04, size)};
    } else {
      object.shape = Cylinder{0.05, size};
    }
    objects.push_back(object);
  }
  return Scene("s", objects);
}

/// Changes stiffnesses and moves surfaces by some millimetres, or returns a new scene in rare
/// cases.
Scene changed(const Scene& before, Random& random) {
  if (random.chance(0.2)) return scene(random);
  std::vector<Object> objects = before.objects();
  for (Object& object : objects) {
    if (random.chance(0.7))
      object.material.stiffness = std::clamp(
          object.material.stiffness * std::pow(10.0, random.uniform(-2.0, 2.0)), 1.0, 1e6);
    if (random.chance(0.5)) object.pose.position += random.uniform(0.0, 0.005) * random.direction();
    if (random.chance(0.2)) object.pose.orientation = turn(random, 0.3) * object.pose.orientation;
  }
  return Scene("s", objects);
}

/// Simulates a hand that moves to places near the surfaces and sometimes rests.
class Hand {
 public:
  explicit Hand(Random& random) : random_(random) {}
  const Vec3& next() {
    if (left_ == 0) {
      rests_ = random_.chance(0.5);
      left_ = 20 + static_cast<int>(random_.uniform(0.0, 150.0));
      const Vec3 goal(random_.uniform(-0.01, 0.01), random_.uniform(-0.01, 0.01),
                      random_.uniform(-0.012, 0.004));
      step_ = rests_ ? Vec3::Zero() : Vec3((goal - at_) / left_);
    }
    --left_;
    at_ += step_;
    return at_;
  }

 private:
  Random& random_;
  Vec3 at_ = Vec3(0.0, 0.0, 0.02), step_ = Vec3::Zero();
  int left_ = 0;
  bool rests_ = false;
};

/// Returns this scene with another material for an object.
Scene remade(const Scene& before, std::size_t object, Random& random) {
  Scene next = before;
  next.set_material(object, material(random));
  return next;
}

struct ReloadResult {
  int reloads = 0, risen = 0;
  double steepest = 0.0;  // largest rise of the force divided by its limit
};

enum class By : std::uint8_t { reload, live_change };

/// Applies random reloads or random live changes of materials under a hand.
void play(std::uint64_t seed, Storage storage, ReloadResult& seen, By by = By::reload) {
  Random random(seed);
  SessionParameters p = parameters("contact_frame");
  p.storage = storage;
  Bench bench(p);
  std::vector<std::unique_ptr<Scene>> all;  // The session uses the last scene.
  all.push_back(std::make_unique<Scene>(scene(random)));
  Session session({"tester", "s", bench.spec, p}, *all.back());
  const double c = 2.0 * bench.spec.damping.least() / p.servo_period;  // [N/m]
  const double slew = bench.spec.max_force / (0.5 * p.hold_time);      // [N/s]
  const int every = 1 + static_cast<int>(random.uniform(0.0, 300.0));  // ticks between reloads
  Hand hand(random);
  Vec3 force = Vec3::Zero(), before = Vec3::Zero();
  Command held;
  // [J] work of the hand in this contact: normal and frictional
  double pressed = 0.0, rubbed = 0.0;
  Vec3 commanded = Vec3::Zero();
  bool known = false;
  for (int n = 0; n < 3000; ++n) {
    if (n % every == every - 1) {
      if (by == By::reload) {
        all.push_back(std::make_unique<Scene>(changed(*all.back(), random)));
        session.enter(Session::Place(*all.back(), nullptr));
      } else {
        const auto count = static_cast<double>(all.back()->objects().size());
        const auto object = static_cast<std::size_t>(random.uniform(0.0, 0.999 * count));
        all.push_back(std::make_unique<Scene>(remade(*all.back(), object, random)));
        session.adopt(*all.back()->view(""), object);
      }
      ++seen.reloads;
    }
    const Vec3 place = hand.next();
    const double moved = known ? (place - before).norm() : 0.0;
    const Command given = bench.tick(at(place.x(), place.y(), place.z()));
    const Vec3 felt = given.force();
    // Condition (C) of docs/bounding.md lets the force rise by c |dx| as the hand moves. A scene
    // change may add the slew limit, for any stiffness and depth. Elastic storage may display its
    // stored force at once.
    if (storage == Storage::minimal) {
      const double rise = felt.norm() - force.norm(), most = c * moved + slew * kTick;
      ASSERT_LE(rise, 1.001 * most + 1e-9) << "seed " << seed << " tick " << n;
      seen.steepest = std::max(seen.steepest, rise / most);
      seen.risen += rise > 1e-6 && moved == 0.0 ? 1 : 0;
    } else {
      // The work has a normal and a frictional part, as in the bound's channels. Sliding along a
      // surface stores no elastic energy.
      const Vec3 way = known ? Vec3(place - before) : Vec3::Zero();
      pressed = std::max(0.0, pressed - held.elastic.dot(way)) + 0.5 * c * moved * moved;
      rubbed = std::max(0.0, rubbed - held.frictional.dot(way));
      ASSERT_LE(felt.squaredNorm() / (2.0 * c), 1.001 * (pressed + rubbed) + 1e-9)
          << "seed " << seed << " tick " << n;
      if (commanded.isZero(0.0)) pressed = rubbed = 0.0;  // the contact ended
    }
    ASSERT_EQ(bench.servo.port().violations(), 0u) << "seed " << seed << " tick " << n;
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = bench.servo.sample();
    const Reply reply = session.take(batch, bench.now).reply;
    commanded = reply.command.elastic;
    bench.servo.take(reply, bench.now);
    held = given;
    force = felt;
    before = place;
    known = true;
  }
}

TEST(ReloadForce, NeverJumpsWhateverTheSceneBecomes) {
  ReloadResult seen;
  for (const std::uint64_t seed : test::seeds(1, 60, 30))
    ASSERT_NO_FATAL_FAILURE(play(seed, Storage::minimal, seen));
  EXPECT_GT(seen.reloads, test::rounds(1000));
  EXPECT_GT(seen.risen, test::rounds(100));  // Resting hands must feel changes.
  EXPECT_GT(seen.steepest, 0.9);             // Changes must use the full slew limit.
}

TEST(ReloadForce, NeverNeedsMoreThanTheHandHasPressedWhereElasticStorageKeepsIt) {
  ReloadResult seen;
  for (const std::uint64_t seed : test::seeds(1001, 60, 30))
    ASSERT_NO_FATAL_FAILURE(play(seed, Storage::elastic, seen));
  EXPECT_GT(seen.reloads, test::rounds(1000));
}

TEST(ReloadForce, NeverJumpsWhateverALiveChangeMakesOfAMaterial) {
  ReloadResult seen;
  for (const std::uint64_t seed : test::seeds(2001, 60, 30))
    ASSERT_NO_FATAL_FAILURE(play(seed, Storage::minimal, seen, By::live_change));
  EXPECT_GT(seen.reloads, test::rounds(1000));
  EXPECT_GT(seen.risen, test::rounds(100));
  EXPECT_GT(seen.steepest, 0.9);
}

/// A default session shapes the force of its local model. A hand rests in a floor, and the floor's
/// stiffness changes a hundredfold up and down. The force must not rise faster than a fade falls,
/// and the port must stay passive.
TEST(ReloadForce, AShapedHandThatRestsFeelsAStiffnessComeInSteps) {
  for (const std::uint64_t seed : test::seeds(3001, 20, 10)) {
    Random random(seed);
    const SessionParameters p = usual_parameters();
    Bench bench(p);
    Object floor;
    floor.name = "floor";
    floor.material.stiffness = 300.0;
    floor.shape = Plane{};
    std::vector<std::unique_ptr<Scene>> all;
    all.push_back(std::make_unique<Scene>("s", std::vector<Object>{floor}));
    Session session({"tester", "s", bench.spec, p}, *all.back());
    const double slew = bench.spec.max_force / (0.5 * p.hold_time);  // [N/s]
    double before = 0.0, largest = 0.0;
    for (int n = 0; n < 3000; ++n) {
      if (n > 500 && n % 200 == 0) {
        Material m = all.back()->objects()[0].material;
        m.stiffness = std::pow(10.0, random.uniform(1.5, 3.7));
        all.push_back(std::make_unique<Scene>(*all.back()));
        all.back()->set_material(0, m);
        session.adopt(*all.back()->view(""), 0);
      }
      // Moves down into the floor and stays there
      const double z = std::max(-0.002, 0.001 - 1e-5 * n);
      const double felt = bench.tick(at(0.0, 0.0, z)).force().norm();
      if (n > 500) {
        ASSERT_LE(felt - before, 1.001 * slew * kTick + 1e-9) << "seed " << seed << " tick " << n;
        largest = std::max(largest, felt);
      }
      ASSERT_EQ(bench.servo.port().violations(), 0u) << "seed " << seed << " tick " << n;
      before = felt;
      SampleBatch batch;
      batch.count = 1;
      batch.samples[0] = bench.servo.sample();
      bench.servo.take(session.take(batch, bench.now).reply, bench.now);
    }
    EXPECT_GT(largest, 0.3) << "seed " << seed;
  }
}

}  // namespace
}  // namespace feltwire::reload_force_test
