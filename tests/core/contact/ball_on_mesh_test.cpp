// Tests a ball as the tool on meshes.

#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/ball.hpp"
#include "tests/core/held_tools.hpp"
#include "tests/core/moving.hpp"
#include "tests/core/support.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::ball_on_mesh_test {
namespace {

using test::kBall;
using test::kRough;
using test::mesh_object;
using test::object;
using test::placed;
using test::Wanderer;

// A ball on a mesh must give bitwise the force of a mesh with this radius: with friction, damping,
// smooth normals, both sides and the mesh's own radius.
TEST(BallOnMesh, IsFeltAsAMeshOfThatRadius) {
  const std::vector<TriangleSoup> soups = {test::icosphere(0.05, 3),
                                           test::box({0.05, 0.04, 0.03}, 4),
                                           test::torus(0.045, 0.02, 60, 30), test::sheet(0.05, 8)};
  int in_all = 0;
  for (std::size_t which = 0; which < soups.size(); ++which)
    for (const bool smooth : {false, true})
      for (const double own : {0.0, 0.0025})
        for (const Side side : {Side::outside, Side::inside}) {
          MeshOptions options{.double_sided = which == 3, .smooth = smooth, .radius = own};
          const Object bare = mesh_object(soups[which], options, kRough, side);
          options.radius += kBall;
          const Object thick = mesh_object(soups[which], options, kRough, side);
          ContactMemory of_ball, of_point;
          const double in = side == Side::outside ? 0.04 : 0.06;
          Wanderer hand(7 + which, side == Side::outside ? 0.08 : 0.01, in);
          int touched = 0;
          for (int n = 0; n < 1000; ++n) {
            const Tool tool = hand.step();
            const Command a = touch(bare, tool, of_ball, kBall), b = touch(thick, tool, of_point);
            ASSERT_EQ(a, b) << which << " " << n;
            touched += a.elastic != Vec3::Zero();
          }
          EXPECT_GT(touched, 0) << which << " " << (side == Side::outside);
          in_all += touched;
        }
  EXPECT_GT(in_all, 10'000);
}

// Closed form: a ball on a box gives the force of a point on a box with rounded edges and corners.
TEST(BallOnMesh, RoundsTheEdgesOfABox) {
  const Vec3 half(0.05, 0.04, 0.03);
  Scene scene("s", {mesh_object(test::box(half, 5), {}, {.stiffness = 1000.0})});
  scene.set_tool({.radius = kBall, .body = nullptr});
  const Object analytic = object("box", Box{half}, {.stiffness = 1000.0});
  test::Random random(11);
  int faces = 0, rounded = 0;
  for (int run = 0; run < 300; ++run) {
    // The ball approaches a surface point along a normal of a face, an edge or a corner.
    Vec3 foot, out = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = random.chance(0.5) ? 1.0 : -1.0;
      const bool at_face = random.chance(0.5);
      foot[axis] = at_face ? sign * half[axis] : random.uniform(-0.9, 0.9) * half[axis];
      if (at_face) out[axis] = sign * random.uniform(0.1, 1.0);
    }
    if (out.isZero()) continue;
    out.normalize();
    TouchMemory memory = scene.memory();
    Command felt;
    const double deepest = random.uniform(0.1, 0.9) * kBall;
    for (double gap = 2.0 * kBall; gap > deepest; gap -= 2e-4)
      felt = scene.touch({foot + gap * out, Vec3::Zero()}, memory);
    felt = scene.touch({foot + deepest * out, Vec3::Zero()}, memory);
    ContactMemory of_box;
    const Command expected = touch(analytic, {foot + deepest * out, Vec3::Zero()}, of_box, kBall);
    ASSERT_LT((felt.elastic - expected.elastic).norm(), 1e-4) << run << " " << out.transpose();
    EXPECT_NEAR(felt.elastic.norm(), 1000.0 * (kBall - deepest), 1e-4);
    ++((out.array() != 0.0).count() == 1 ? faces : rounded);
  }
  EXPECT_GT(faces, 30);
  EXPECT_GT(rounded, 60);
}

TEST(BallOnMesh, OnASphereOfFacetsIsOnASphereWithinTheFacets) {
  constexpr double kRadius = 0.09, kDepth = 0.002, kStiffness = 5000.0;
  for (const int level : {3, 5}) {
    Scene scene("s", {mesh_object(test::icosphere(kRadius, level), {}, {.stiffness = kStiffness})});
    scene.set_tool({.radius = kBall, .body = nullptr});
    const double corner = 0.77 / std::pow(2.0, level);  // [rad] largest error of a facet
    const double sagitta = kRadius * (1.0 - std::cos(corner));
    TouchMemory memory = scene.memory();
    for (int n = 0; n < 2000; ++n) {
      const double turn = 1.1e-3 * n, depth = std::min(kDepth, 2e-5 * n - 0.001);
      const Vec3 out(std::cos(turn) * std::cos(0.7 * turn), std::sin(turn) * std::cos(0.7 * turn),
                     std::sin(0.7 * turn));
      const Command c = scene.touch({(kRadius + kBall - depth) * out, Vec3::Zero()}, memory);
      if (depth < kDepth) continue;
      ASSERT_NEAR(c.elastic.norm(), kStiffness * kDepth, kStiffness * sagitta * 1.1) << n;
      ASSERT_LT(test::angle(c.elastic, out), corner) << n;
    }
  }
}

// The tree finds the objects. The force must equal the sum over all objects.
TEST(BallOnMesh, AmongManyObjectsIsTheSumOfThem) {
  std::vector<Object> objects;
  const auto mesh = std::make_shared<MeshSurface>(TriangleMesh(test::icosphere(0.012, 2)));
  test::Random random(13);
  for (int i = 0; i < 200; ++i) {
    const std::string name = "o" + std::to_string(i);
    const Shape shape = i % 3 == 0   ? Shape(Box{Vec3(0.01, 0.008, 0.006)})
                        : i % 3 == 1 ? Shape(Capsule{0.005, 0.01})
                                     : Shape(Mesh{mesh});
    objects.push_back(placed(object("", shape, kRough), name.c_str(),
                             0.1 * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), 0.3)));
  }
  Scene scene("s", objects);
  scene.set_tool({.radius = kBall, .body = nullptr});
  ASSERT_TRUE(scene.views()[0].by_tree());
  TouchMemory memory = scene.memory();
  std::vector<ContactMemory> each(objects.size());
  int touched = 0;
  for (int n = 0; n < 3000; ++n) {
    const double t = 1e-3 * n;
    const Tool tool{{0.1 * std::sin(2 * t), 0.1 * std::sin(3.1 * t), 0.03 + 0.01 * std::sin(7 * t)},
                    Vec3(0.1, 0.2, 0.3)};
    Command sum;
    for (std::size_t i = 0; i < objects.size(); ++i)
      add_touch(scene.objects()[i], tool, each[i], kBall, sum);
    const Command felt = scene.touch(tool, memory);
    ASSERT_LT((felt.force() - sum.force()).norm(), 1e-9) << n;
    touched += felt != Command{};
  }
  EXPECT_GT(touched, 1000);
}

}  // namespace
}  // namespace feltwire::ball_on_mesh_test
