// The neighbour search computes contact only with moving objects near the hand. The result must
// equal a search of all objects bitwise. No object may pass a hand at any speed.

#include "core/dynamics/neighbour_list.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/moving.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::neighbour_list_test {
namespace {

using test::body;
using test::Hand;
using test::kWeightless;
using test::moving;
using test::object;

TEST(NeighbourSearch, AListHoldsUntilToolAndObjectsHaveComeAsFarAsItsMargin) {
  const std::vector<Object> two = {object("a", Sphere{0.02}, {}, {0, 0, 0}),
                                   object("b", Sphere{0.02}, {}, {1, 0, 0})};
  NeighbourSearch reach(two, 0.01);  // Each object extends 30 mm. The margin is 30 mm too.
  NeighbourList near;
  EXPECT_FALSE(near.known());
  EXPECT_FALSE(reach.holds(near, Vec3::Zero()));
  EXPECT_TRUE(reach.is_outside(0, Vec3(0.0301, 0, 0)));
  EXPECT_FALSE(reach.is_outside(0, Vec3(0.0299, 0, 0)));
  EXPECT_TRUE(reach.is_near(0, Vec3(0.0599, 0, 0)));
  EXPECT_FALSE(reach.is_near(0, Vec3(0.0601, 0, 0)));
  const Vec3 start(0.1, 0, 0);
  reach.mark(near, start);
  EXPECT_TRUE(near.known());
  EXPECT_TRUE(reach.holds(near, start + Vec3(0, 0.0299, 0)));
  EXPECT_FALSE(reach.holds(near, start + Vec3(0, 0.0301, 0)));
  // Each step counts the largest movement of all objects.
  const auto moved = [&](double first, double second) {
    reach.place(0, {Vec3(first, 0, 0), Quaternion::Identity()});
    reach.place(1, {Vec3(1, second, 0), Quaternion::Identity()});
    reach.placed();
  };
  moved(0.004, 0.01);
  moved(0.009, 0.01);
  EXPECT_TRUE(reach.holds(near, start + Vec3(0, 0, 0.0149)));
  EXPECT_FALSE(reach.holds(near, start + Vec3(0, 0, 0.0151)));
  moved(0.009, -0.01);
  EXPECT_FALSE(reach.holds(near, start));
  near.forget();
  EXPECT_FALSE(near.known());
}

Object mesh(const char* name, const TriangleSoup& soup, const MeshOptions& options,
            const Material& material, const Vec3& position) {
  Object o = test::mesh_object(soup, options, material);
  o.name = name;
  o.pose.position = position;
  return o;
}

TEST(NeighbourSearch, TheBallIsAboutTheMiddleHoweverTheObjectIsTurned) {
  const Vec3 half(0.01, 0.01, 0.01), middle(0.5, 0, 0);
  std::vector<Object> objects = {
      mesh("off", test::moved(test::box(half), middle), {}, {}, Vec3(0, 0, 1))};
  NeighbourSearch reach(objects, 0.0);
  EXPECT_FALSE(reach.is_outside(0, Vec3(0.5, 0, 1)));
  const Quaternion quarter(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitZ()));
  reach.place(0, {Vec3(0, 0, 1), quarter});
  EXPECT_TRUE(reach.is_outside(0, Vec3(0.5, 0, 1)));
  EXPECT_FALSE(reach.is_outside(0, Vec3(0, 0.5, 1) + 0.99 * half));
  EXPECT_TRUE(reach.is_outside(0, Vec3(0, 0.5, 1) + 1.01 * half));
}

/// Returns a body that oscillates between its position 0 and 2 `rest`. The speed in the middle is
/// `rest` times `turn`.
Body swinging(const char* name, Joint joint, const Vec3& axis, double rest, double turn,
              const Vec3& position) {
  Body b = body(name, 1.0, position);
  b.joint = joint;
  b.axis = axis;
  b.rest = rest;
  b.stiffness = turn * turn;  // for a mass of 1 kg
  b.collides = false;
  return b;
}

/// Thin plates that fly to and fro at up to 10 m/s, swinging doors, a ring, and a box without a
/// mesh. All objects are so soft that the hands hardly move them.
Scene crowd(double radius) {
  const Material soft{.stiffness = 1.0},
      rough{.stiffness = 2.0, .damping = 1e-3, .static_friction = 0.6, .dynamic_friction = 0.4};
  const TriangleSoup plate = test::box(Vec3(0.05, 0.05, 5e-4), 2);
  const TriangleSoup door = test::moved(test::box(Vec3(0.06, 1e-3, 0.04)), Vec3(0.07, 0, 0));
  std::vector<Object> objects = {
      mesh("along z", plate, {}, soft, {0, 0, -0.4}),
      mesh("along x", plate, {.double_sided = true}, rough, {-0.5, 0.02, 0}),
      mesh("a ball", plate, {.radius = radius}, soft, {0.05, 0.3, 0.1}),
      mesh("door", door, {}, rough, {0.1, -0.1, 0}),
      mesh("smooth ring", test::torus(0.05, 0.01, 16, 8), {.smooth = true}, soft, {0, 0.15, 0.2}),
      object("box", Box{Vec3(0.03, 0.02, 0.01)}, rough, {0.1, 0.1, -0.3}),
      mesh("thing far off", door, {}, soft, {0.3, 0.3, 0.3})};
  std::vector<Body> bodies = {
      swinging("0", Joint::slide, Vec3::UnitZ(), 0.4, 25.0, objects[0].pose.position),
      swinging("1", Joint::slide, Vec3::UnitX(), 0.5, 20.0, objects[1].pose.position),
      swinging("2", Joint::slide, -Vec3::UnitY(), 0.3, 15.0, objects[2].pose.position),
      swinging("3", Joint::hinge, Vec3::UnitZ(), 1.5, 1.0, objects[3].pose.position),
      swinging("4", Joint::slide, -Vec3::UnitZ(), 0.2, 10.0, objects[4].pose.position),
      swinging("5", Joint::slide, Vec3::UnitZ(), 0.3, 20.0, objects[5].pose.position),
      swinging("6", Joint::hinge, Vec3(1, 1, 0), 1.0, 0.5, objects[6].pose.position)};
  return moving(objects, {0, 1, 2, 3, 4, 5, 6}, bodies, kWeightless);
}

/// Computes contact with every object at every sample, and at every tick without a sample.
struct Asker {
  explicit Asker(World& in) : world(in), memory(in.objects().size()) {}
  Command ask(const Tool& tool) {
    Command sum;
    for (std::size_t i = 0; i < memory.size(); ++i) {
      const Vec3 against = tool.velocity - world.velocity_at(i, tool.position);
      const Command part = touch(world.objects()[i], {tool.position, against}, memory[i]);
      sum.elastic += part.elastic;
      sum.frictional += part.frictional;
    }
    return sum;
  }
  World& world;
  std::vector<ContactMemory> memory;
};

/// Passes through the objects in turn, in their frames, at up to 10 m/s. With `jumps` it reaches
/// the next object at once.
class Wanderer {
 public:
  Wanderer(const World& world, std::uint64_t seed, bool jumps)
      : world_(world), random_(seed), jumps_(jumps) {}
  Vec3 next() {
    if (left_-- == 0) choose();
    own_ += kDefaultTick * velocity_;
    const Pose& pose = world_.objects()[which_].pose;
    const Vec3 way = pose.position + pose.orientation * own_ - place_;
    const double most = jumps_ ? 1.0 : 10.0 * kDefaultTick / std::max(1e-9, way.norm());
    return place_ += std::min(1.0, most) * way;
  }

 private:
  void choose() {
    which_ = static_cast<std::size_t>(
        random_.uniform(0.0, static_cast<double>(world_.objects().size())));
    own_ = random_.uniform(0.0, 0.3) * random_.direction();
    left_ = static_cast<int>(random_.uniform(20.0, 80.0));
    velocity_ =
        (0.06 * random_.direction() - own_) * random_.uniform(0.5, 2.0) / (kDefaultTick * left_);
  }
  const World& world_;
  test::Random random_;
  bool jumps_;
  std::size_t which_ = 0;
  int left_ = 0;
  Vec3 own_ = Vec3::Zero(), velocity_ = Vec3::Zero(), place_ = Vec3::Zero();
};

TEST(NeighbourSearch, TheSameBitsAsAskingAllAlways) {
  std::size_t felt = 0, began = 0, asked = 0, samples = 0;
  for (const std::uint64_t seed : test::seeds(1, 8, 2)) {
    // A ball's proxy takes small steps. After a jump the proxy needs some samples, but only if the
    // search included the object.
    const bool jumps = seed % 2 == 0;
    const Scene scene = crowd(jumps ? 0.0 : 1e-3);
    World world(scene);
    Hand hand(world);
    Asker asker(world);
    Wanderer wanderer(world, seed, jumps);
    bool touched = false;
    const std::size_t before = test::allocations();
    for (int n = 0; n < 1500; ++n) {
      const Vec3 place = wanderer.next();
      const Tool tool{place, Vec3(0.1, 0, -0.2)};
      const Command sum = asker.ask(tool);
      const Command got = hand.touch(tool.position, tool.velocity);
      ASSERT_EQ(got, sum) << seed << " " << n;
      const bool touches = !sum.elastic.isZero(0.0);
      felt += touches ? 1 : 0;
      began += touches && !touched ? 1 : 0;
      touched = touches;
      asked += hand.contacts.near.parts.size();
      ++samples;
      world.push(hand.contacts, hand.memory, 1.0);
      ASSERT_TRUE(world.step());
      const int silent = n % 40 == 0 ? 3 : 0;  // ticks without a sample of the hand
      for (int i = 0; i < silent; ++i) {
        world.push(hand.contacts, hand.memory, 1.0);
        asker.ask({place, Vec3::Zero()});
        ASSERT_TRUE(world.step());
      }
    }
#ifndef FELTWIRE_SANITIZED
    EXPECT_EQ(test::allocations(), before);
#else
    static_cast<void>(before);
#endif
  }
  EXPECT_GT(felt, samples / 20);
  EXPECT_GT(began, test::rounds(50u));
  EXPECT_LT(asked, 4 * samples);  // The search must skip most of the seven objects.
}

// A plate of 1 mm comes at 10 m/s from far away. The hand rests, escapes or approaches. The plate
// must move the hand along and must never pass it.
TEST(NeighbourSearch, AThinPlateNeverPassesAHand) {
  for (const double speed : {0.0, 2.0, -10.0})
    for (const double beside : {0.0, 0.03, 0.0495}) {  // [m] The plate ends at 0.05.
      const Vec3 begin(0, 0, -0.5);
      const Scene scene = moving(
          {mesh("plate", test::box(Vec3(0.05, 0.05, 5e-4), 3), {}, {.stiffness = 1.0}, begin)}, {0},
          {swinging("plate", Joint::slide, Vec3::UnitZ(), 0.5, 20.0, begin)}, kWeightless);
      World world(scene);
      Hand hand(world);
      int felt = 0;
      for (int n = 0; n < 150; ++n) {
        const Vec3 place(beside, 0.7 * beside, std::max(-0.3, 0.05 + speed * kDefaultTick * n));
        const double above = place.z() - world.objects()[0].pose.position.z();
        const double force = hand.step(place).elastic.z();
        // The force must match the depth below the upper face of the plate.
        EXPECT_NEAR(force, std::max(0.0, 5e-4 - above), 1e-9) << speed << " " << n;
        felt += force > 0.0 ? 1 : 0;
      }
      EXPECT_GT(felt, 10) << speed << " " << beside;
    }
}

// A hand jumps from far beside the plate to the rising plate. Relative to the plate, the hand must
// come from above.
TEST(NeighbourSearch, AJumpIsSeenFromWhereThePlateWas) {
  const Vec3 begin(0, 0, -0.5);
  const Scene scene =
      moving({mesh("plate", test::box(Vec3(0.05, 0.05, 5e-4), 3), {}, {.stiffness = 1.0}, begin)},
             {0}, {swinging("plate", Joint::slide, Vec3::UnitZ(), 0.5, 20.0, begin)}, kWeightless);
  World world(scene), ahead(scene);
  for (int n = 0; n < 80; ++n) {
    world.step();
    ahead.step();
  }
  ahead.step();
  const double now = world.objects()[0].pose.position.z();
  const double height = ahead.objects()[0].pose.position.z() + 2e-4;
  ASSERT_GT(height - now, 8e-3);
  Hand hand(world);
  Asker asker(world);
  EXPECT_EQ(hand.touch({0.3, 0, height}), asker.ask({{0.3, 0, height}, Vec3::Zero()}));
  EXPECT_TRUE(hand.contacts.near.parts.empty());
  world.step();
  const Command felt = hand.touch({0, 0, height});
  EXPECT_EQ(felt, asker.ask({{0, 0, height}, Vec3::Zero()}));
  EXPECT_NEAR((felt.elastic - Vec3(0, 0, 3e-4)).norm(), 0.0, 1e-9);
}

// The hand jumps from one side to the other, with or without the plate in its neighbour list.
TEST(NeighbourSearch, AJumpThroughAPlateIsCaught) {
  const Vec3 begin(0, 0, -0.5);
  const Scene scene =
      moving({mesh("plate", test::box(Vec3(0.05, 0.05, 5e-4), 3), {}, {.stiffness = 1.0}, begin)},
             {0}, {swinging("plate", Joint::slide, Vec3::UnitZ(), 0.5, 20.0, begin)}, kWeightless);
  for (const double above : {0.3, 0.1}) {
    World world(scene);
    Hand hand(world);
    hand.touch(begin + Vec3(0, 0, above));
    EXPECT_EQ(hand.contacts.near.parts.size(), above < 0.2 ? 1u : 0u);
    EXPECT_NEAR(hand.touch(begin - Vec3(0, 0, 0.3)).elastic.z(), 0.3 + 5e-4, 1e-9) << above;
  }
}

// A jump out of an object must end the contact. The next contact must have a new stick point.
TEST(NeighbourSearch, AJumpOutOfAThingLetsGo) {
  const Material rough{.stiffness = 100.0, .static_friction = 0.6, .dynamic_friction = 0.4};
  const Scene scene = moving({object("box", Box{Vec3::Constant(0.03)}, rough)}, {0},
                             {body("box", 1e3)}, kWeightless);
  World world(scene);
  Hand hand(world);
  EXPECT_GT(hand.touch({0, 0, 0.029}).elastic.z(), 0.0);
  EXPECT_EQ(hand.touch({0, 0, 1.0}).force(), Vec3::Zero());
  EXPECT_EQ(hand.contacts.forces[0], Vec3::Zero());
  hand.touch({1.0, 0, 1.0});
  EXPECT_TRUE(hand.contacts.near.parts.empty());
  const Command back = hand.touch({0.01, 0, 0.029});
  EXPECT_GT(back.elastic.z(), 0.0);
  EXPECT_EQ(back.frictional, Vec3::Zero());
}

// The next sample must find the bodies that moved without a push from the hand.
TEST(NeighbourSearch, AHandThatIsSilentForLongFindsWhatMovedMeanwhile) {
  const Scene scene =
      moving({object("ball", Sphere{0.02}, {.stiffness = 100.0})}, {0},
             {swinging("ball", Joint::slide, Vec3::UnitX(), 0.5, 20.0, Vec3::Zero())}, kWeightless);
  World world(scene);
  Hand hand(world);
  hand.step({0.5, 0, 0});
  EXPECT_TRUE(hand.contacts.near.parts.empty());
  while (world.objects()[0].pose.position.x() < 0.5) ASSERT_TRUE(world.step());
  EXPECT_GT(hand.touch({0.5, 0, 0}).elastic.norm(), 0.0);
  EXPECT_EQ(hand.contacts.near.parts.size(), 1u);
}

}  // namespace
}  // namespace feltwire::neighbour_list_test
