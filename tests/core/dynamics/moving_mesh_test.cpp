// Tests moving meshes: their mass, their contact with a hand, and their collisions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/dynamics/mass_properties.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "tests/core/moving.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::moving_mesh_test {
namespace {

using test::body;
using test::Hand;
using test::kWeightless;
using test::moving;
using test::object;
using test::Random;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Shape mesh(const TriangleSoup& soup) { return test::mesh_object(soup).shape; }

Pose random_pose(Random& random) {
  return {random.uniform(0.0, 0.5) * random.direction(),
          Quaternion(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.direction()))};
}

void expect_same(const MassProperties& a, const MassProperties& b, double relative) {
  EXPECT_NEAR(a.volume, b.volume, relative * b.volume);
  EXPECT_LE((a.center - b.center).norm(), relative);
  EXPECT_LE((a.inertia - b.inertia).norm(), relative * b.inertia.norm());
}

// The integral over a polyhedron must be exact for a box in any tessellation and pose.
TEST(MassProperties, OfATessellatedBoxIsTheBoxs) {
  Random random(1);
  for (int run = 0; run < 20; ++run) {
    const Vec3 half(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1),
                    random.uniform(0.01, 0.1));
    const Pose pose = random_pose(random);
    TriangleSoup soup = test::box(half, 1 + run % 4);
    for (Vec3& v : soup.vertices) v = pose.position + pose.orientation * v;
    expect_same(mass_properties(mesh(soup)), placed(mass_properties(Shape(Box{half})), pose),
                1e-11);
  }
}

TEST(MassProperties, RoundSolidsAreTheLimitOfTheirTriangles) {
  for (const Shape& shape :
       {Shape(Sphere{0.03}), Shape(Capsule{0.02, 0.05}), Shape(Cylinder{0.04, 0.03}),
        Shape(Cone{0.04, 0.03}), Shape(Torus{0.05, 0.02})})
    expect_same(mass_properties(mesh(tessellate(shape, 400))), mass_properties(shape), 3e-4);
}

TEST(MassProperties, PartsAddUpToTheWhole) {
  const Vec3 half(0.03, 0.02, 0.01);
  const auto part = mass_properties(Shape(Box{half}));
  const MassProperties both = together(placed(part, {Vec3(0.03, 0, 0), Quaternion::Identity()}),
                                       placed(part, {Vec3(-0.03, 0, 0), Quaternion::Identity()}));
  expect_same(both, mass_properties(Shape(Box{Vec3(0.06, 0.02, 0.01)})), 1e-14);
}

TEST(MassProperties, KnowConvexFromHollow) {
  EXPECT_TRUE(is_convex(TriangleMesh(test::box(Vec3(0.1, 0.2, 0.3), 3))));
  EXPECT_TRUE(is_convex(TriangleMesh(test::icosphere(0.05, 3))));
  EXPECT_FALSE(is_convex(TriangleMesh(test::torus(0.05, 0.02, 20, 10))));
  EXPECT_FALSE(is_convex(TriangleMesh(test::sheet(0.05))));
  // Two convex meshes together are not convex.
  EXPECT_FALSE(is_convex(TriangleMesh(test::joined(
      test::icosphere(0.01, 2), test::moved(test::icosphere(0.01, 2), Vec3(0.05, 0, 0))))));
}

Scene one_body(const Shape& shape, const Material& material = {},
               const MechanismOptions& options = {}, const Vec3& at = Vec3::Zero()) {
  return moving(
      {object("thing", shape, material), object("floor", Plane{}, material, -0.1 * Vec3::UnitZ())},
      {0, -1}, {body("thing", 0.3, at)}, options);
}

// After a spin, the mesh must move like the box. MuJoCo therefore gets equal mass, centre and
// inertia.
TEST(MovingMesh, MovesAsTheBoxThatItIs) {
  const Vec3 half(0.05, 0.03, 0.02);
  const Material slick{.stiffness = 1000};
  const Scene analytic = one_body(Box{half}, slick, kWeightless);
  const Scene cut = one_body(mesh(test::box(half, 3)), slick, kWeightless);
  EXPECT_THAT(cut.mechanism()->warnings(), IsEmpty());
  World a(analytic), b(cut);
  Hand left(a), right(b);
  double felt = 0.0;
  for (int n = 0; n < 1500; ++n) {
    // A hand pushes beside the centre of mass and leaves.
    const Vec3 place = n < 150 ? Vec3(0.04, -0.01, 0.0199 - 1e-5 * n) : Vec3(0.0, 0.0, 1.0);
    const Vec3 force = left.step(place).force();
    EXPECT_LE((right.step(place).force() - force).norm(), 1e-9);
    felt += force.norm();
    // MuJoCo stores a mesh in its principal axes, and finds them by iteration.
    EXPECT_LE((b.objects()[1].pose.position - a.objects()[1].pose.position).norm(), 1e-8);
    EXPECT_LE(b.objects()[1].pose.orientation.angularDistance(a.objects()[1].pose.orientation),
              1e-7);
    if (::testing::Test::HasFailure()) FAIL() << "step " << n;
  }
  EXPECT_GT(felt, 1.0);
  EXPECT_GT(a.objects()[1].pose.orientation.angularDistance(Quaternion::Identity()), 0.5);
}

// The mesh falls on a floor. Its hull must come to rest like the box.
TEST(MovingMesh, RestsOnTheFloorByItsHull) {
  const Vec3 half(0.05, 0.03, 0.02);
  const Scene analytic = one_body(Box{half}), cut = one_body(mesh(test::box(half, 2)));
  World a(analytic), b(cut);
  for (int n = 0; n < 1500; ++n) {
    ASSERT_TRUE(a.step());
    ASSERT_TRUE(b.step());
  }
  EXPECT_NEAR(b.objects()[1].pose.position.z(), half.z() - 0.1, 2e-4);
  EXPECT_LE((b.objects()[1].pose.position - a.objects()[1].pose.position).norm(), 2e-4);
  EXPECT_LE(b.objects()[1].pose.orientation.angularDistance(a.objects()[1].pose.orientation), 2e-3);
  // A static closed mesh must carry a box too.
  const Scene on_mesh = moving(
      {object("table", mesh(test::moved(test::box(Vec3(0.2, 0.2, 0.05), 2), Vec3(0, 0, -0.15)))),
       object("thing", Box{half})},
      {-1, 0}, {body("thing", 0.3)});
  World c(on_mesh);
  for (int n = 0; n < 1500; ++n) ASSERT_TRUE(c.step());
  EXPECT_NEAR(c.objects()[1].pose.position.z(), half.z() - 0.1, 2e-4);
}

// A shape without a MuJoCo geom must rest on the geoms that replace it.
TEST(MovingMesh, ConesAndRingsLieOnTheFloor) {
  const struct {
    Shape shape;
    double low;  // [m] distance from the shape's origin down to its lowest point
  } cases[] = {{Cone{0.04, 0.03}, 0.03}, {Torus{0.05, 0.015}, 0.015}};
  for (const auto& c : cases) {
    const Scene scene = one_body(c.shape);
    EXPECT_THAT(scene.mechanism()->warnings(), IsEmpty());
    World world(scene);
    for (int n = 0; n < 1500; ++n) ASSERT_TRUE(world.step());
    EXPECT_NEAR(world.objects()[1].pose.position.z(), c.low - 0.1, 3e-4);
    EXPECT_LT(world.objects()[1].pose.orientation.angularDistance(Quaternion::Identity()), 0.02);
  }
}

// Newton's third law, up to rounding and without tunnelling. Two hands stroke and press a tumbling
// ring.
TEST(MovingMesh, TakesTheMomentumThatTheHandsAreRefused) {
  const Material grippy{
      .stiffness = 1000, .damping = 1.0, .static_friction = 0.8, .dynamic_friction = 0.6};
  const Scene scene = moving({object("ring", mesh(test::torus(0.05, 0.02, 40, 20)), grippy)}, {0},
                             {body("ring", 0.4)}, kWeightless);
  EXPECT_THAT(scene.mechanism()->warnings(),
              ElementsAre(HasSubstr("object 'ring': hands feel the mesh, but bodies run into its "
                                    "convex hull")));
  World world(scene);
  Hand left(world), right(world);
  Vec3 given = Vec3::Zero();
  double pushed = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const Pose& ring = world.objects()[0].pose;
    const double t = kDefaultTick * n;
    // Positions in the ring's frame: on the outside of the tube and in the hole.
    const std::array<Vec3, 2> own = {
        Vec3(0.0695 + 1e-3 * std::sin(40 * t), 0.004 * std::sin(17 * t), 0.002),
        Vec3(-0.031 + 2e-3 * std::sin(31 * t), 0.003 * std::sin(11 * t), 0.001)};
    int which = 0;
    for (Hand* hand : {&left, &right}) {
      const Vec3 place = ring.position + ring.orientation * own[static_cast<std::size_t>(which++)];
      const Vec3 force = hand->touch(place).force();
      world.push(hand->contacts, hand->memory, 1.0);
      given += kDefaultTick * force;
      pushed += kDefaultTick * force.norm();
    }
    ASSERT_TRUE(world.step());
  }
  EXPECT_GT(pushed, 0.5);  // [N s]
  EXPECT_NEAR((world.momentum() + given).norm(), 0.0, 1e-12 * pushed);
}

// A mesh that flies at 10 m/s towards a resting hand must not pass it.
TEST(MovingMesh, ComesToTheHandAndIsFelt) {
  const Scene scene =
      moving({object("plate", mesh(test::box(Vec3(0.05, 0.05, 1e-3))), {.stiffness = 500})}, {0},
             {body("plate", 0.3)}, {.gravity = Vec3(0, 0, 1000.0)});
  World world(scene);
  Hand hand(world);
  const Vec3 place(0.01, 0.0, 0.0505);
  bool felt = false;
  for (int n = 0; n < 14 && !felt; ++n) felt = hand.step(place).elastic.z() > 0.0;
  EXPECT_TRUE(felt);
  EXPECT_GT(world.velocity_at(0, place).z(), 8.0);
}

TEST(MovingMesh, IsRefusedWithoutAVolume) {
  const auto error = [](const TriangleSoup& soup) -> std::string {
    try {
      one_body(mesh(soup));
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(
      error(test::sheet(0.05)),
      AllOf(HasSubstr("object 'thing': mesh: its surface is not closed (4 open edges, 1 hole "),
            HasSubstr(" across, 0 with more than two triangles, 0 between triangles turned "
                      "against each other), so it has no volume and cannot move; mend it, or take "
                      "it off its body")));
  TriangleSoup inside_out = test::icosphere(0.05, 1);
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_THAT(error(inside_out), HasSubstr("its normals look inwards"));
  EXPECT_EQ(error(test::icosphere(0.05, 1)), "no error");
}

// The patches must move with the mesh.
TEST(MovingMesh, IsInTheLocalModelWithItsVelocity) {
  const Scene scene = moving({object("ball", mesh(test::icosphere(0.05, 4)), {.stiffness = 1000})},
                             {0}, {body("ball", 0.3)}, {.gravity = Vec3(0, 0, -1.0)});
  World world(scene);
  Hand hand(world);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 100; ++n) hand.step(Vec3(0.0, 0.0, 0.07));
  const LocalModel model = local_model(world, Vec3(0.0, 0.0, 0.06), hand.memory);
  EXPECT_EQ(test::allocations(), before);
  ASSERT_EQ(model.count, 1);
  EXPECT_NEAR(model.patches[0].velocity.z(), -0.1, 1e-9);
  EXPECT_NEAR(model.patches[0].point.z(), world.objects()[0].pose.position.z() + 0.05, 2e-4);
}

}  // namespace
}  // namespace feltwire::moving_mesh_test
