// The local model of a mesh for a ball has the triangles and the ball's radius. Edges and corners
// are therefore round.

#include <gtest/gtest.h>

#include "core/local_model_extraction/extract.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"
#include "tests/support/followed_hand.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::ball_patches_test {
namespace {

using test::Random;

constexpr double kStiffness = 1200.0;  // [N/m]
constexpr double kBall = 4e-3;         // [m]
const Material kDry{.stiffness = kStiffness, .static_friction = 0.5, .dynamic_friction = 0.3};

struct Rolled {
  int ticks = 0, spoke = 0, touched = 0, round = 0;
  double worst = 0.0;  // [N] largest error
  double slope = 0.0;  // largest error beyond 0.1 mm, relative to the force of the movement
};

/// Hands move at random near a mesh, with a model every 20 ticks. `direction_of` returns a
/// direction from the mesh's centre. `round` counts ticks in which the force differs from every
/// triangle's normal.
template <class DirectionOf>
Rolled roll(const Object& object, Random& random, DirectionOf direction_of, double from = 0.15) {
  const Scene scene("s", {object});
  const TriangleMesh& triangles = std::get<Mesh>(object.shape).surface->mesh();
  Rolled sum;
  for (int run = 0; run < 40; ++run) {
    test::FollowedHand hand(scene, 20);
    const Vec3 away = direction_of();
    double far = from;
    const double step = object.felt_from == Side::outside ? -1e-3 : 1e-3;
    while (hand.approach({far * away, Vec3::Zero()}).elastic.isZero(0.0) && far > 0.0 && far < 0.2)
      far += step;
    test::WanderingHand wanderer(random, far * away, 1.5e-5, 8e-3);
    for (int n = 0; n < 500; ++n) {
      ++sum.ticks;
      if (!hand.step(wanderer.step())) continue;
      ++sum.spoke;
      // Near an edge, the ball's centre amplifies the remaining error of the scene's iteration.
      if (hand.truth().elastic.norm() > 0.6 * kBall * kStiffness) break;
      sum.worst = std::max(sum.worst, hand.error());
      const double way = kStiffness * (hand.tool().position - hand.asked()).norm();
      sum.slope = std::max(sum.slope, (hand.error() - 1e-4 * kStiffness) /
                                          (way + hand.truth().force().norm() + 1e-9));
      if (!hand.memory()[0].touching) continue;
      ++sum.touched;
      const Vec3 along = hand.truth().elastic.normalized();
      double facing = 0.0;
      for (std::uint32_t t = 0;
           t < std::min<std::size_t>(triangles.triangles().size(), 100) && facing < 1.0 - 1e-9; ++t)
        facing = std::max(facing, std::abs(along.dot(triangle_normal(triangles.corners(t)))));
      sum.round += facing < 1.0 - 1e-9 ? 1 : 0;
    }
  }
  return sum;
}

// The scene's own ball stops when a step is below 1e-7 of its radius. The error on an edge is then
// below half a micrometre.
constexpr double kExact = 0.5e-6 * kStiffness;  // [N]

TEST(BallPatches, FacesEdgesAndCornersOfABoxAreRound) {
  Random random(1);
  const Vec3 half(0.05, 0.04, 0.03);
  const Object box = test::mesh_object(test::box(half, 2), {.radius = kBall}, kDry);
  const Rolled anywhere = roll(box, random, [&] { return random.direction(); });
  EXPECT_LE(anywhere.worst, kExact);
  EXPECT_GT(anywhere.touched, 5000);
  EXPECT_GT(anywhere.spoke, anywhere.ticks * 9 / 10);
  const Rolled corner =
      roll(box, random, [&] { return Vec3(half + 2e-3 * random.direction()).normalized(); });
  EXPECT_LE(corner.worst, kExact);
  EXPECT_GT(corner.round, 3000);
  EXPECT_GT(corner.spoke, corner.ticks * 9 / 10);
  const Rolled edge = roll(box, random, [&] {
    return Vec3(half.x(), half.y(), random.uniform(-0.02, 0.02)).normalized();
  });
  EXPECT_LE(edge.worst, kExact);
  EXPECT_GT(edge.round, 3000);
}

/// A corner of a box must have three faces, for a point and for a ball.
TEST(BallPatches, AtACornerAllThreeFacesAreKnown) {
  const Vec3 half(0.05, 0.04, 0.03);
  for (const double radius : {0.0, kBall}) {
    const Scene scene("s", {test::mesh_object(test::box(half, 2), {.radius = radius}, kDry)});
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      TouchMemory memory = scene.memory();
      const Vec3 at = sign.cwiseProduct(half + Vec3(1e-3, 1.1e-3, 1.2e-3));
      scene.touch({2.0 * at, Vec3::Zero()}, memory);
      scene.touch({at, Vec3::Zero()}, memory);
      EXPECT_EQ(memory[0].touching, radius > 0.0);
      const LocalModel model = local_model(scene, at, memory);
      EXPECT_EQ(model.count, 3);
      EXPECT_GT(model.reach, 0.02);
    }
  }
}

// A ball is pressed over an edge until its centre is in the solid. The ball must slide to the side
// to which the scene's ball slides.
TEST(BallPatches, FromAnEdgeTheBallFallsToTheSameFace) {
  Random random(4);
  const Vec3 half(0.05, 0.04, 0.03);
  for (const double angle : {0.0, 1.0}) {  // a box, and obtuse edges
    const Object object = test::mesh_object(
        angle > 0.0 ? test::icosphere(0.05, 0) : test::box(half, 2), {.radius = kBall}, kDry);
    const Scene scene("s", {object});
    const TriangleMesh& triangles = std::get<Mesh>(object.shape).surface->mesh();
    int fell = 0;
    for (int run = 0; run < 200; ++run) {
      const auto t = static_cast<std::uint32_t>(
          random.uniform(0.0, static_cast<double>(triangles.triangles().size())));
      const auto corners = triangles.corners(t);
      const std::uint32_t other = triangles.neighbour(t, 0);
      const Vec3 a = triangle_normal(corners), b = triangle_normal(triangles.corners(other));
      if (a.dot(b) > 0.9) continue;  // no edge
      const Vec3 edge = 0.5 * (corners[0] + corners[1]), out = (a + b).normalized();
      const Vec3 aside = (a - b).normalized();
      test::FollowedHand hand(scene, 20);
      const double off = (random.chance(0.5) ? 1.0 : -1.0) * random.uniform(3e-5, 4e-4);
      for (double height = 6e-3; height > -2e-3; height -= 2e-5) {
        if (!hand.step({edge + height * out + off * aside, Vec3::Zero()})) continue;
        // Directly over the edge, rounding decides the side.
        if (height > -2e-4 && height < 1.2e-3) continue;
        ASSERT_LE(hand.error(), 0.02) << run << " height " << height << " off " << off;
        fell += height < 0.0 ? 1 : 0;
      }
    }
    EXPECT_GT(fell, 3000);
  }
}

// In one sample the ball moves from the front of an edge to the other side. The ball rests neither
// on the first face nor on the second, but slides down. The scene's ball takes some samples.
TEST(BallPatches, AcrossAnEdgeTheBallRollsToTheSameFace) {
  Random random(5);
  const Scene scene("s", {test::mesh_object(test::box(Vec3(0.05, 0.05, 0.05), 2), {.radius = kBall},
                                            {.stiffness = kStiffness})});
  constexpr int kRuns = 200;
  constexpr double kNear = 1e-4;  // [m] distance from the edge
  int others = 0, crossed = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vec3 edge(0.05, 0.05, 0.012);
    const Vec3 over(random.uniform(0.0, kNear), random.uniform(0.0, kNear), 0.0);
    const Vec3 behind(random.uniform(-kNear, 0.0), random.uniform(-kNear, 0.0), 0.0);
    test::FollowedHand hand(scene, 20);
    for (int n = 50; n > 0; --n)
      hand.step({edge + over + 1e-4 * n * over.normalized(), Vec3::Zero()});
    hand.step({edge + over, Vec3::Zero()});
    for (int n = 0; n < 300; ++n) hand.step({edge + behind, Vec3::Zero()});
    others += hand.error() > 0.1 * kBall * kStiffness ? 1 : 0;
    // The ball landed on the farther face.
    crossed +=
        (over.x() > over.y()) != (hand.truth().elastic.x() > hand.truth().elastic.y()) ? 1 : 0;
  }
  EXPECT_LE(others, kRuns / 50);  // Rounding decides these cases.
  EXPECT_GT(crossed, kRuns / 10);
}

TEST(BallPatches, InAHollowTheBallStandsOffAllWalls) {
  Random random(2);
  const Vec3 half(0.05, 0.04, 0.03);
  const Object room = test::mesh_object(test::box(half, 2), {.radius = kBall}, kDry, Side::inside);
  for (const bool corner : {false, true}) {
    const Rolled inside = roll(
        room, random, [&] { return corner ? half.normalized() : random.direction(); }, 1e-3);
    EXPECT_LE(inside.worst, kExact);
    EXPECT_GT(inside.touched, 5000);
    EXPECT_GT(inside.spoke, inside.ticks / 2);
  }
}

// Tests obtuse edges, and facets smaller than the ball.
TEST(BallPatches, AnIcosahedronAndAFineSphere) {
  Random random(3);
  const auto anywhere = [&] { return random.direction(); };
  const Rolled coarse =
      roll(test::mesh_object(test::icosphere(0.05, 0), {.radius = kBall}, kDry), random, anywhere);
  EXPECT_LE(coarse.worst, kExact);
  EXPECT_GT(coarse.touched, 3000);
  EXPECT_GT(coarse.round, 100);
  for (const Side side : {Side::outside, Side::inside}) {
    const Rolled fine = roll(test::mesh_object(test::icosphere(0.05, 5), {.radius = kBall},
                                               Material{.stiffness = kStiffness}, side),
                             random, anywhere, side == Side::outside ? 0.15 : 0.01);
    EXPECT_LE(fine.slope, 2.0 * kPatchSlope);
    EXPECT_GT(fine.touched, 5000);
    EXPECT_GT(fine.spoke, fine.ticks * 8 / 10);
  }
}

// The model has the triangles at their positions. The ball has an offset from them.
TEST(BallPatches, AnnounceTheTrianglesAndTheBall) {
  const Scene scene("s", {test::mesh_object(test::box(Vec3(0.05, 0.05, 0.05)), {.radius = kBall})});
  TouchMemory memory = scene.memory();
  const auto at = [&](double z) {
    const Vec3 position(0.01, 0.0, z);
    scene.touch({position, Vec3::Zero()}, memory);
    return local_model(scene, position, memory);
  };
  for (const double z : {0.06, 0.053}) {
    const LocalModel model = at(z);
    ASSERT_GE(model.count, 1);
    EXPECT_TRUE(model.patches[0].point.isApprox(Vec3(0.01, 0.0, 0.05)));
    EXPECT_EQ(model.patches[0].offset, kBall);
    EXPECT_EQ(model.patches[0].touching, z < 0.054);
    EXPECT_TRUE(model.patches[0].faceted);
    EXPECT_FALSE(model.patches[0].rough);
    // The far side of the box is hidden. Only the searched region may limit the valid radius.
    EXPECT_GT(model.reach, 0.04);
  }
  // In a tight hollow, the ball touches more points than a model can describe.
  const Scene bowl("s", {test::mesh_object(test::icosphere(1.5 * kBall, 4), {.radius = kBall}, {},
                                           Side::inside)});
  TouchMemory inside = bowl.memory();
  const Vec3 low(0.0, 0.0, -0.6 * kBall);
  bowl.touch({Vec3::Zero(), Vec3::Zero()}, inside);
  bowl.touch({low, Vec3::Zero()}, inside);
  EXPECT_LT(local_model(bowl, low, inside).reach, 1e-3);
}

}  // namespace
}  // namespace feltwire::ball_patches_test
