// Local models of meshes and grids must be exact for flat parts. For fitted parts, the error is
// proportional to the hand's movement. The models must be empty where a fit is invalid.

#include "core/local_model_extraction/fitted_patches.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/followed_hand.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::fitted_patches_test {
namespace {

using test::Random;

constexpr double kStiffness = 1200.0;  // [N/m]
const Material kDry{.stiffness = kStiffness, .static_friction = 0.5, .dynamic_friction = 0.3};
const Material kSmooth{.stiffness = kStiffness};

Object mesh(const TriangleSoup& soup, const Material& material, Side side = Side::outside,
            const MeshOptions& options = {}) {
  return test::mesh_object(soup, options, material, side);
}

Object grid(const Shape& solid, double resolution, Side side = Side::outside) {
  Object o;
  o.name = "grid";
  o.shape = Grid{std::make_shared<DistanceGrid<float>>(solid_of(solid),
                                                       GridOptions{.resolution = resolution})};
  o.felt_from = side;
  o.material = kSmooth;
  return o;
}

struct Followed {
  int spoke = 0, touched = 0, together = 0, ticks = 0;
  double reach = 0.0;  // [m] mean valid radius
};

/// A hand moves at random near the surface, with a model every 20 ticks. `core` [m] is a point in
/// the solid. While the model alone gives the force, the error may be stiffness * (`exact` +
/// `slope` * (distance from the model's position + depth)).
Followed follow(Object object, Random& random, double slope, double exact,
                const Vec3& core = Vec3::Zero()) {
  constexpr int kEvery = 20;
  object.pose.position = random.uniform(0.0, 0.5) * random.direction();
  object.pose.orientation =
      Quaternion(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.direction()));
  const Scene scene("s", {object});
  Followed sum;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    test::FollowedHand hand(scene, kEvery);
    test::WanderingHand wanderer(random, test::led_to(hand, object, core, random), 4e-5, 8e-3);
    for (int n = 0; n < 600; ++n) {
      const Tool tool = wanderer.step();
      ++sum.ticks;
      if (!hand.step(tool)) continue;
      ++sum.spoke;
      const bool touching = hand.memory()[0].touching;
      sum.touched += touching ? 1 : 0;
      int in = 0;
      for (const SurfacePatch& patch : hand.model().view())
        in += height_above(patch, Vec3::Zero(), tool.position).height < patch.offset ? 1 : 0;
      sum.together += in > 1 && touching ? 1 : 0;
      const Vec3 truth = hand.truth().force(), said = hand.said().force();
      const double may =
          slope * (kStiffness * (tool.position - hand.asked()).norm() + truth.norm()) +
          kStiffness * exact;
      EXPECT_LE(hand.error(), may)
          << "run " << run << " tick " << n << " truth " << truth.transpose() << " said "
          << said.transpose() << " patches " << hand.model().count;
      if (hand.error() > may) return sum;
    }
    sum.reach += hand.reach() / kRuns;
  }
  return sum;
}

// Flat faces and their edges must be exact for any triangulation: convex edges with friction,
// concave edges and obtuse edges.
TEST(FittedPatches, FlatFacesAndTheirEdgesAreExact) {
  Random random(1);
  for (const int squares : {1, 5}) {
    const Followed box =
        follow(mesh(test::box(Vec3(0.05, 0.04, 0.03), squares), kDry), random, 0.0, 1e-12);
    EXPECT_GT(box.touched, 10000);
    EXPECT_GT(box.spoke, box.ticks / 2);
    const Followed room =
        follow(mesh(test::box(Vec3(0.05, 0.04, 0.03), squares), kSmooth, Side::inside), random, 0.0,
               1e-12);
    EXPECT_GT(room.touched, 5000);
    EXPECT_GT(room.spoke, room.ticks / 2);
  }
  for (const Side side : {Side::outside, Side::inside}) {
    const Followed obtuse = follow(mesh(test::icosphere(0.05, 0), kDry, side), random, 0.0, 1e-11);
    EXPECT_GT(obtuse.touched, 5000);
    EXPECT_GT(obtuse.together, 1000);
    EXPECT_GT(obtuse.spoke, obtuse.ticks / 3);
  }
}

// The error of a fit is proportional to the hand's movement since the model, plus the error of the
// facets.
TEST(FittedPatches, FineMeshesAreCurvedPatches) {
  Random random(2);
  constexpr double kRadius = 0.05;
  for (const Side side : {Side::outside, Side::inside}) {
    const Followed ball =
        follow(mesh(test::icosphere(kRadius, 5), kSmooth, side), random, 2.0 * kPatchSlope, 1e-4);
    EXPECT_GT(ball.touched, 10000);
    EXPECT_GT(ball.spoke, ball.ticks * 8 / 10);
    EXPECT_GT(ball.reach, 4e-3);
    const Followed ring = follow(mesh(test::torus(0.05, 0.02, 200, 100), kSmooth, side), random,
                                 4.0 * kPatchSlope, 2e-4, Vec3(0.05, 0.0, 0.0));
    EXPECT_GT(ring.spoke, ring.ticks / 2);
  }
}

TEST(FittedPatches, GridsAreCurvedPatches) {
  Random random(3);
  for (const Side side : {Side::outside, Side::inside}) {
    const Followed ball = follow(grid(Sphere{0.05}, 2e-3, side), random, 2.0 * kPatchSlope, 1e-4);
    EXPECT_GT(ball.touched, 10000);
    EXPECT_GT(ball.spoke, ball.ticks * 8 / 10);
    EXPECT_GT(ball.reach, 8e-3);
  }
  const Followed can = follow(grid(Cylinder{0.04, 0.05}, 1e-3), random, 4.0 * kPatchSlope, 2e-4);
  EXPECT_GT(can.spoke, can.ticks / 3);
}

// A patch cannot describe the curvature of cones and rings. Such a patch is valid only near the
// tool.
TEST(FittedPatches, ConesAndRingsAreCurvedPatches) {
  Random random(4);
  const auto shown = [](const Shape& shape, Side side) {
    Object o;
    o.name = "it";
    o.shape = shape;
    o.felt_from = side;
    o.material = kSmooth;
    return o;
  };
  for (const Side side : {Side::outside, Side::inside}) {
    const Followed cone = follow(shown(Cone{0.05, 0.04}, side), random, 2.0 * kPatchSlope, 1e-9);
    EXPECT_GT(cone.touched, 5000);
    EXPECT_GT(cone.spoke, cone.ticks / 3);
    const Followed ring = follow(shown(Torus{0.05, 0.02}, side), random, 2.0 * kPatchSlope, 1e-9,
                                 Vec3(0.05, 0.0, 0.0));
    EXPECT_GT(ring.touched, 1000);
    EXPECT_GT(ring.spoke, ring.ticks / 5);
  }
}

/// A hand moves around a faceted ball at constant depth, across 20 facets or more.
TEST(FittedPatches, FrictionRoundFacetsIsTheScenes) {
  constexpr double kRadius = 0.05, kStep = 1e-4;  // [m]
  for (const int level : {1, 2, 3, 5})
    for (const double ball : {0.0, 3e-3}) {
      const Scene scene(
          "s", {mesh(test::icosphere(kRadius, level), kDry, Side::outside, {.radius = ball})});
      const MeshSurface& surface = *std::get<Mesh>(scene.objects()[0].shape).surface;
      test::FollowedHand hand(scene, 20);
      const Vec3 u = Vec3(0.9, 0.3, -0.2).normalized(),
                 v = u.cross(Vec3(0.1, 1.0, 0.4)).normalized();
      const auto at = [&](double turn) {
        const Vec3 out = std::cos(turn) * u + std::sin(turn) * v;
        const auto near = surface.nearest(kRadius * out, kRadius);
        return Vec3(near.point + (ball - 1e-3) * out);
      };
      hand.approach({2.0 * at(0.0), Vec3::Zero()});
      double truth = 0.0, error = 0.0;
      int spoke = 0, facets = 0;
      std::uint32_t facet = 0;
      for (int n = 0; n * kStep < 2.0 * M_PI * kRadius; ++n) {
        const Tool tool{at(kStep / kRadius * n), Vec3::Zero()};
        if (!hand.step(tool)) continue;
        ++spoke;
        facets += hand.memory()[0].feature.triangle != facet ? 1 : 0;
        facet = hand.memory()[0].feature.triangle;
        truth += hand.truth().frictional.norm();
        error += (hand.said().frictional - hand.truth().frictional).norm();
      }
      if (level > 1) {
        EXPECT_GT(facets, 20) << level;
      }
      EXPECT_GT(truth / spoke, 0.2 * kStiffness * 1e-3);
      EXPECT_LT(error, 0.04 * truth) << "level " << level << " ball " << ball;
      RecordProperty("error", std::to_string(error / truth));
    }
}

LocalModel model_at(const Scene& scene, const Vec3& position) {
  TouchMemory memory = scene.memory();
  scene.touch({position, Vec3::Zero()}, memory);
  return local_model(scene, position, memory);
}

TEST(FittedPatches, ASphereIsABallOfItsRadius) {
  constexpr double kRadius = 0.05;
  for (const Object& object :
       {mesh(test::icosphere(kRadius, 6), kSmooth), grid(Sphere{kRadius}, 1e-3)})
    for (const double off : {-2e-3, 2e-3}) {
      const Vec3 away = Vec3(0.3, -0.5, 0.81).normalized();
      const LocalModel model = model_at(Scene("s", {object}), (kRadius + off) * away);
      ASSERT_EQ(model.count, 1);
      EXPECT_NEAR(model.patches[0].curvature, 1.0 / kRadius, 0.05 / kRadius);
      EXPECT_TRUE(model.patches[0].axis.isZero(0.0));
      EXPECT_NEAR((model.patches[0].point - kRadius * away).norm(), 0.0, 2e-4);
      EXPECT_EQ(model.patches[0].touching, off < 0.0 && object.name == "mesh" ? true : off < 0.0);
    }
  const LocalModel can =
      model_at(Scene("s", {grid(Cylinder{0.04, 0.06}, 1e-3)}), Vec3(0.041, 0.0, 0.01));
  ASSERT_EQ(can.count, 1);
  EXPECT_NEAR(can.patches[0].curvature, 25.0, 1.0);
  EXPECT_NEAR(std::abs(can.patches[0].axis.z()), 1.0, 1e-3);
}

// The valid radius must end at the border of a sheet, at the far side of a one-sided surface, and
// at other parts of the mesh.
TEST(FittedPatches, EndWhereTheSurfaceDoes) {
  const Scene sheet("s", {mesh(test::sheet(0.03, 3), kSmooth)});
  const LocalModel above = model_at(sheet, Vec3(0.02, 0.0, 1e-3));
  ASSERT_EQ(above.count, 1);
  EXPECT_NEAR(above.reach, std::hypot(0.01, 1e-3), 1e-9);
  EXPECT_NEAR(above.patches[0].radius, 0.01, 1e-9);
  // Nothing holds the tool there.
  const LocalModel below = model_at(sheet, Vec3(0.02, 0.0, -1e-3));
  EXPECT_EQ(below.count, 0);
  EXPECT_NEAR(below.reach, 1e-3, 1e-9);

  const Scene both("s",
                   {mesh(test::sheet(0.03, 3), kSmooth, Side::outside, {.double_sided = true})});
  const LocalModel under = model_at(both, Vec3(0.01, 0.0, -1e-3));
  ASSERT_EQ(under.count, 1);
  EXPECT_EQ(under.patches[0].normal, Vec3(-Vec3::UnitZ()));

  // A ball is 5 mm over a plate in one mesh.
  const Scene parts("s",
                    {mesh(test::joined(test::box(Vec3(0.1, 0.1, 0.01)),
                                       test::moved(test::icosphere(0.01, 3), Vec3(0, 0, 0.025))),
                          kSmooth)});
  const LocalModel between = model_at(parts, Vec3(0.0, 0.0, 0.011));
  ASSERT_GE(between.count, 1);
  EXPECT_LE(between.reach, 4e-3 + 1e-9);
  // The tool moves through a plate of 2 mm. The upper face must still hold the tool.
  const Scene plate("s", {mesh(test::box(Vec3(0.1, 0.1, 1e-3)), kSmooth)});
  TouchMemory memory = plate.memory();
  for (double z = 5e-3; z > -3e-3; z -= 1e-3)
    plate.touch({Vec3(0.01, 0.02, z), Vec3::Zero()}, memory);
  const LocalModel through = local_model(plate, Vec3(0.01, 0.02, -2e-3), memory);
  ASSERT_GE(through.count, 1);
  EXPECT_EQ(through.patches[0].normal, Vec3::UnitZ());
  EXPECT_GT(through.reach, 0.05);
}

TEST(FittedPatches, NeverAllocate) {
  const Scene scene("s", {mesh(test::icosphere(0.05, 5), kSmooth), [] {
                            Object o = grid(Sphere{0.03}, 2e-3);
                            o.pose.position = Vec3(0.0, 0.0, 0.09);
                            return o;
                          }()});
  TouchMemory memory = scene.memory();
  const std::size_t before = test::allocations();
  for (int n = 0; n < 300; ++n) {
    const Vec3 position = (0.0505 - 1e-5 * n) * Vec3(std::cos(0.01 * n), 0.0, std::sin(0.01 * n));
    scene.touch({position, Vec3::Zero()}, memory);
    local_model(scene, position, memory);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace feltwire::fitted_patches_test
